// The determinant of three moving vectors as a polynomial in t, with bounds on its rounding error. Included once for
// each instruction set by foreach_target.h of Highway.
#include <limits>

#include <volccd/query/block_lanes-inl.hpp>

#if defined(VOLCCD_DETERMINANT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_DETERMINANT_INL
#undef VOLCCD_DETERMINANT_INL
#else
#define VOLCCD_DETERMINANT_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

constexpr double binomial(int n, int k) { return k == 0 ? 1 : binomial(n - 1, k - 1) * n / k; }

/// Bernstein coefficients of det(e0, e1, e2)(t), each multiplied by binomial(degree, k).
template <int kControlPoints>
struct Determinant {
  static constexpr int kDegree = 3 * (kControlPoints - 1);
  Lanes coefficients[kDegree + 1];

  HWY_INLINE explicit Determinant(const Lanes3 (&e)[3][kControlPoints]) {
    constexpr int n = kControlPoints - 1;
    Lanes3 normal[2 * n + 1];
    bool begun[kDegree + 1] = {};
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const Lanes3 part = weighted(cross(e[1][i], e[2][j]), binomial(n, i) * binomial(n, j));
        normal[i + j] = i == 0 || j == n ? part : add(normal[i + j], part);
      }
    for (int i = 0; i <= n; ++i)
      for (int k = 0; k <= 2 * n; ++k) {
        const Lanes part = dot(weighted(e[0][i], binomial(n, i)), normal[k]);
        coefficients[i + k] = begun[i + k] ? hn::Add(coefficients[i + k], part) : part;
        begun[i + k] = true;
      }
  }

 private:
  static HWY_INLINE Lanes3 weighted(const Lanes3& a, double weight) {
    return weight == 1 ? a : scaled(a, broadcast(weight));
  }
};

/// Bound on the error of the determinant, or infinity if an overflow is possible. It consists of a part without and a
/// part with a binomial factor.
struct DeterminantError {
  Lanes fixed, scaled;

  HWY_INLINE DeterminantError(const Lanes3 (&extent)[3], double factor) {
    const Lanes3 a = trusted(extent[0]), b = trusted(extent[1]), c = trusted(extent[2]);
    const Lanes x = hn::Add(hn::Mul(b.y, c.z), hn::Mul(b.z, c.y)), y = hn::Add(hn::Mul(b.z, c.x), hn::Mul(b.x, c.z)),
                z = hn::Add(hn::Mul(b.x, c.y), hn::Mul(b.y, c.x));
    const Lanes permanent = add3(hn::Mul(a.x, x), hn::Mul(a.y, y), hn::Mul(a.z, z));
    // The areas are tested as well: their sums may overflow although a small `a` keeps the permanent in range.
    const auto in_range = hn::Lt(add3(x, y, z), broadcast(kGreatestMagnitude));
    const Lanes infinite = broadcast(std::numeric_limits<double>::infinity());
    scaled = hn::Mul(hn::IfThenElse(in_range, trusted(permanent), infinite), broadcast(factor));
    fixed = hn::Mul(broadcast(kDeterminantUnderflow), hn::Add(broadcast(1), add3(a.x, a.y, a.z)));
  }
};

/// An upper bound on the areas of a tetrahedron with the edges a, b and c at one vertex, throughout the step: twice its
/// faces, and the cross products of opposite edges. Its volume times 6, divided by these seven areas, is its four
/// heights and the three distances between opposite edges. Infinite, or NaN, if an overflow is possible.
template <int kControlPoints>
HWY_INLINE Lanes greatest_area(const Lanes3 (&a)[kControlPoints], const Lanes3 (&b)[kControlPoints],
                               const Lanes3 (&c)[kControlPoints]) {
  constexpr double kMinArea = 0x1p-449;  // more than the length of a vector whose square underflows
  Lanes square = hn::Zero(Tag()), size = square;
  const auto include = [&](const Lanes3& first, const Lanes3& second) HWY_ATTR {
    const Lanes3 area = cross(first, second);
    square = hn::Max(square, dot(area, area));
  };
  for (int i = 0; i < kControlPoints; ++i) {
    const Lanes3 ab = sub(b[i], a[i]), bc = sub(c[i], b[i]), ca = sub(a[i], c[i]);
    size = hn::Max(size, add3(norm1(a[i]), norm1(b[i]), norm1(c[i])));
    // The vectors at other times are averages of those at the control points, independently of each other.
    for (int j = 0; j < kControlPoints; ++j) {
      include(a[i], b[j]);
      include(b[i], c[j]);
      include(c[i], a[j]);
      include(ab, sub(c[j], a[j]));
      include(ab, c[j]);
      include(bc, a[j]);
      include(ca, b[j]);
    }
  }
  const Lanes rounding = hn::Mul(broadcast(64 * kUnitRoundoff), hn::Mul(trusted(size), trusted(size)));
  return hn::Add(hn::Add(hn::Mul(hn::Sqrt(square), broadcast(kAreaSlack)), broadcast(kMinArea)), trusted(rounding));
}

/// Whether all coefficients, and therefore the polynomial throughout [0, 1], are proven to have the same sign.
struct DeterminantSigns {
  LaneMask positive, negative;

  template <int kControlPoints>
  HWY_INLINE DeterminantSigns(const Determinant<kControlPoints>& det, const DeterminantError& error) {
    constexpr int degree = Determinant<kControlPoints>::kDegree;
    const Lanes first = hn::Add(error.scaled, error.fixed);
    positive = hn::Gt(det.coefficients[0], first);
    negative = hn::Lt(det.coefficients[0], hn::Neg(first));
    for (int k = 1; k <= degree; ++k) {
      const Lanes bound = hn::Add(hn::Mul(error.scaled, broadcast(binomial(degree, k))), error.fixed);
      positive = hn::And(positive, hn::Gt(det.coefficients[k], bound));
      negative = hn::And(negative, hn::Lt(det.coefficients[k], hn::Neg(bound)));
    }
  }
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
