// Signs of determinants that are certain in spite of rounding.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/numerics/rounding.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// det(a, b, c) of vectors that are exact or are rounded differences of points.
struct CertifiedDeterminant {
  double value, bound;  ///< |value - exact value| < bound; infinite if an overflow is possible

  /// `displacement`: the value for vectors that are changed by up to this length each is within the bound, too.
  CertifiedDeterminant(const Vec3& a, const Vec3& b, const Vec3& c, double displacement = 0)
      : value(a.dot(b.cross(c))) {
    // At most 9 roundings in each of the 6 products; the sum of their magnitudes is less than the product of the
    // 1-norms.
    const double product = norm1(a) * norm1(b) * norm1(c);
    bound = product < kGreatestMagnitude && norm1(b) * norm1(c) < kGreatestMagnitude
                ? 32 * kUnitRoundoff * product + kDeterminantUnderflow * (1 + norm1(a))
                : std::numeric_limits<double>::infinity();
    if (displacement > 0) {
      const double x = norm1(a), y = norm1(b), z = norm1(c), d = displacement;
      bound += d * (x * y + y * z + z * x + d * (x + y + z) + d * d) * kAreaSlack;
    }
  }
  bool positive() const { return value > bound; }
  bool negative() const { return value < -bound; }

 private:
  static double norm1(const Vec3& a) { return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]); }
};

inline bool certainly_positive(const Vec3& a, const Vec3& b, const Vec3& c) {
  return CertifiedDeterminant(a, b, c).positive();
}
inline bool certainly_negative(const Vec3& a, const Vec3& b, const Vec3& c) {
  return CertifiedDeterminant(a, b, c).negative();
}

}  // namespace volccd::detail
