#include <volccd/narrowphase/detail/coplanarity.hpp>

#include <volccd/narrowphase/detail/double_double.hpp>
#include <volccd/narrowphase/detail/vector3.hpp>

namespace volccd::detail {
namespace {

using Vector = Vector3<DoubleDouble>;

Vector sum(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

}  // namespace

CoplanarityCubic refined_coplanarity(const TestPoints& x, double scale) {
  std::array<Vector, 3> start, end;
  double e[3][3];
  // As detail::scaled_difference.
  const auto scaled_difference = [scale](double a, double b) {
    if (scale <= 1) return exact_difference(scale * a, scale * b);
    const DoubleDouble d = exact_difference(a, b);
    return DoubleDouble{scale * d.high, scale * d.low};
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      start[i][k] = scaled_difference(x[i + 1][k], x[0][k]);
      end[i][k] = scaled_difference(x[i + 1][k + 3], x[0][k + 3]);
      e[i][k] = std::max(std::abs(start[i][k].high), std::abs(end[i][k].high));
    }
  const Vector n0 = cross(start[1], start[2]), n2 = cross(end[1], end[2]);
  const Vector n1 = sum(cross(start[1], end[2]), cross(end[1], start[2]));
  CoplanarityCubic cubic;
  cubic.b = {dot(start[0], n0).high, (dot(start[0], n1) + dot(end[0], n0)).high,
             (dot(start[0], n2) + dot(end[0], n1)).high, dot(end[0], n2).high};
  const double permanent = e[0][0] * (e[1][1] * e[2][2] + e[1][2] * e[2][1]) +
                           e[0][1] * (e[1][2] * e[2][0] + e[1][0] * e[2][2]) +
                           e[0][2] * (e[1][0] * e[2][1] + e[1][1] * e[2][0]);
  // A dozen operations with errors of at most 2^-101 each. Underflow costs at most a few 2^-1074 for each product,
  // times two further factors below kGreatestSize.
  cubic.error = 0x1p-90 * permanent + 0x1p-800;
  return cubic;
}

}  // namespace volccd::detail
