// The 16-DOP of a moving element, as a scalar template over any number type. Section 7.2 of the paper compares its cost
// with that of OBBs (moving_obb.hpp). For measurement only: the broad phases have bounds of their own
// (numerics/kdop.hpp).
//
// Guarantee (double): the element, with its vertices at any time of [0, 1] on the segments between their two positions,
// lies in the bounds, in exact arithmetic; bounds that are found apart have no point in common. Pre: at least one
// point; coordinates are finite, and 0 or of magnitude 1e-100 to 1e100.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd::reference {

/// Bounds along x, y, z, x+y, x+z, y+z, x-y, x-z.
template <class Scalar>
struct MovingKdop {
  static constexpr std::size_t kAxes = 8;
  std::array<Scalar, kAxes> low, high;
};

namespace bounds_detail {

/// The products of a point with the axes of MovingKdop; each value is rounded once at most.
template <class Scalar>
std::array<Scalar, 8> kdop_products(const Vector3<Scalar>& x) {
  return {x[0], x[1], x[2], x[0] + x[1], x[0] + x[2], x[1] + x[2], x[0] - x[1], x[0] - x[2]};
}

/// Extends [low, high] to the values.
template <class Scalar, std::size_t N>
void extend(std::array<Scalar, N>& low, std::array<Scalar, N>& high, const std::array<Scalar, N>& values) {
  for (std::size_t i = 0; i < N; ++i) {
    low[i] = values[i] < low[i] ? values[i] : low[i];
    high[i] = values[i] > high[i] ? values[i] : high[i];
  }
}

}  // namespace bounds_detail

/// 10 additions for each vertex, 16 comparisons for each position after the first, and the rounding of 10 sums outward.
template <class Scalar>
MovingKdop<Scalar> moving_kdop(std::span<const MovingPoint<Scalar>> points) {
  using std::abs;
  MovingKdop<Scalar> bounds;
  bounds.low = bounds.high = bounds_detail::kdop_products(points[0].x0);
  bounds_detail::extend(bounds.low, bounds.high, bounds_detail::kdop_products(points[0].x1));
  for (const MovingPoint<Scalar>& p : points.subspan(1)) {
    bounds_detail::extend(bounds.low, bounds.high, bounds_detail::kdop_products(p.x0));
    bounds_detail::extend(bounds.low, bounds.high, bounds_detail::kdop_products(p.x1));
  }
  const Scalar rounding(0x1p-51);
  for (std::size_t i = 3; i < MovingKdop<Scalar>::kAxes; ++i) {
    bounds.low[i] = bounds.low[i] - rounding * abs(bounds.low[i]);
    bounds.high[i] = bounds.high[i] + rounding * abs(bounds.high[i]);
  }
  return bounds;
}

/// Whether two k-DOPs are disjoint: at most 16 comparisons.
template <class Scalar>
bool apart(const MovingKdop<Scalar>& a, const MovingKdop<Scalar>& b) {
  for (std::size_t i = 0; i < MovingKdop<Scalar>::kAxes; ++i)
    if (a.low[i] > b.high[i] || b.low[i] > a.high[i]) return true;
  return false;
}

}  // namespace volccd::reference
