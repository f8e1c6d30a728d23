// Signs of determinants that rounding cannot have changed.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/mesh/types.hpp>
#include <volccd/query/rounding.hpp>

namespace volccd::detail {

/// det(a, b, c) of vectors each of which is given exactly, or is a rounded difference of points.
struct CertifiedDeterminant {
  double value, bound;  ///< |value - exact| < bound, infinite where something could overflow

  CertifiedDeterminant(const Vec3& a, const Vec3& b, const Vec3& c) : value(a.dot(b.cross(c))) {
    // At most 9 roundings in each of the 6 products, whose magnitudes sum to less than the product of the 1-norms.
    const double product = norm1(a) * norm1(b) * norm1(c);
    bound = product < kGreatestMagnitude && norm1(b) * norm1(c) < kGreatestMagnitude
                ? 32 * kUnitRoundoff * product + kDeterminantUnderflow * (1 + norm1(a))
                : std::numeric_limits<double>::infinity();
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
