#include <volccd/narrowphase/detail/coplanarity.hpp>

#include <volccd/numerics/double_double.hpp>
#include <volccd/numerics/vector3.hpp>

namespace volccd::detail {
namespace {

using Vector = Vector3<DoubleDouble>;

Vector sum(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

using Extents = double[3][3];

/// Permanent of the matrix with rows a[0], b[1], c[2].
double permanent(const Extents& a, const Extents& b, const Extents& c) {
  return a[0][0] * (b[1][1] * c[2][2] + b[1][2] * c[2][1]) + a[0][1] * (b[1][2] * c[2][0] + b[1][0] * c[2][2]) +
         a[0][2] * (b[1][0] * c[2][1] + b[1][1] * c[2][0]);
}

}  // namespace

CoplanarityCubic refined_coplanarity(const TestPoints& x, double scale, double lo, double hi) {
  std::array<Vector, 3> start, end;
  Extents e, off;
  // The same as detail::scaled_difference.
  const auto scaled_difference = [scale](double a, double b) {
    if (scale <= 1) return exact_difference(scale * a, scale * b);
    const DoubleDouble d = exact_difference(a, b);
    return DoubleDouble{scale * d.high, scale * d.low};
  };
  const auto at = [](double t, const DoubleDouble& a, const DoubleDouble& b) {
    return t == 0 ? a : t == 1 ? b : exact_difference(1, t) * a + DoubleDouble{t, 0} * b;
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const DoubleDouble a = scaled_difference(x[i + 1][k], x[0][k]),
                         b = scaled_difference(x[i + 1][k + 3], x[0][k + 3]);
      start[i][k] = at(lo, a, b);
      end[i][k] = at(hi, a, b);
      // Positions within the step have errors of a few 2^-102 of the whole motion.
      off[i][k] = lo == 0 && hi == 1 ? 0 : 0x1p-98 * std::max(std::abs(a.high), std::abs(b.high));
      e[i][k] = std::max(std::abs(start[i][k].high), std::abs(end[i][k].high)) + off[i][k];
    }
  const Vector n0 = cross(start[1], start[2]), n2 = cross(end[1], end[2]);
  const Vector n1 = sum(cross(start[1], end[2]), cross(end[1], start[2]));
  CoplanarityCubic cubic;
  cubic.b = {dot(start[0], n0).high, (dot(start[0], n1) + dot(end[0], n0)).high,
             (dot(start[0], n2) + dot(end[0], n1)).high, dot(end[0], n2).high};
  // A dozen operations with errors of at most 2^-101 each. Underflow costs at most a few 2^-1074 for each product,
  // multiplied by two further factors that are less than kGreatestSize.
  cubic.error =
      0x1p-90 * permanent(e, e, e) + permanent(off, e, e) + permanent(e, off, e) + permanent(e, e, off) + 0x1p-800;
  return cubic;
}

}  // namespace volccd::detail
