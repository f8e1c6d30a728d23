// Inline definitions for bounded_test.hpp, which includes this file.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <volccd/narrowphase/inclusion/detail/inclusion_bounds.hpp>

namespace volccd::detail {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline Vec3 between(const Vec3& a, const Vec3& b, double t) { return (1 - t) * a + t * b; }

template <int kPoints>
BoundedTest<kPoints>::BoundedTest(FeatureKind kind, const TestPoints& x, double separation) : kind_(kind) {
  store_differences(x, separation, 1);
  const double size = extent_.maxCoeff();
  if (!(size >= kMinSize && size <= kGreatestSize)) store_differences(x, separation, range_scale(x, kPoints));
}

template <int kPoints>
void BoundedTest<kPoints>::store_differences(const TestPoints& x, double separation, double scale) {
  scale_ = scale;
  if (separation > 0) separation_ = std::nextafter(separation * scale, kInfinity);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t c = 0; c < kPoints; ++c)
      for (std::size_t k = 0; k < 3; ++k)
        differences_[i][c][static_cast<int>(k)] = scaled_difference(x[i + 1][3 * c + k], x[0][3 * c + k], scale);
  measure();
}

template <int kPoints>
void BoundedTest<kPoints>::measure() {
  extent_.setConstant(kMinExtent);
  rigid_ = true;
  for (std::size_t i = 0; i < 3; ++i) {
    extents_[i].setConstant(kMinExtent);
    for (const Vec3& e : differences_[i]) {
      extents_[i] = extents_[i].cwiseMax(e.cwiseAbs());
      rigid_ = rigid_ && e == differences_[i][0];
    }
    extent_ = extent_.cwiseMax(extents_[i]);
  }
  const Vec3 &a = extents_[0], &b = extents_[1], &c = extents_[2];
  const double permanent = a.x() * (b.y() * c.z() + b.z() * c.y()) + a.y() * (b.z() * c.x() + b.x() * c.z()) +
                           a.z() * (b.x() * c.y() + b.y() * c.x());
  coplanarity_error_ = determinant_error_factor(kPoints, kPoints - 1) * permanent;
  coplanarity_underflow_ = kDeterminantUnderflow * (1 + a.sum());
  distance_error_ = kDistanceError * extent_.sum() + 32 * kUnitRoundoff * separation_;
}

template <int kPoints>
Differences BoundedTest<kPoints>::at(double t) const {
  Differences d;
  for (std::size_t i = 0; i < 3; ++i) {
    const Curve& e = differences_[i];
    if constexpr (kPoints == 2)
      d[i] = between(e[0], e[1], t);
    else
      d[i] = between(between(e[0], e[1], t), between(e[1], e[2], t), t);
  }
  return d;
}

}  // namespace volccd::detail
