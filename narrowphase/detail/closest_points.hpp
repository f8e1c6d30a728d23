// Closest points of the two features of a test at one time. Works for features without extent and for parallel edges.
#pragma once

#include <array>

#include <volccd/narrowphase/detail/moving_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

struct ClosestPoints {
  /// As in Contact: VF {1, w0, w1, w2}, EE {1-s, s, 1-u, u}; none negative.
  std::array<double, 4> weights;
  /// From the second feature to the first, computed from the weights: whatever rounding did to them, its length is the
  /// distance of two points of the features.
  Vec3 separation;
  double squared_distance;
};

/// From the point of the second feature with these weights to that of the first.
inline Vec3 separation_of(FeatureKind kind, const Differences& d, const std::array<double, 4>& weights) {
  return kind == FeatureKind::vf ? Vec3(-(weights[1] * d[0] + weights[2] * d[1] + weights[3] * d[2]))
                                 : Vec3(weights[1] * d[0] - (weights[2] * d[1] + weights[3] * d[2]));
}

/// Sizes as in range_scale(). The distance is the least one up to about 1e-15 of the size, slivers included.
ClosestPoints closest_points(FeatureKind kind, const Differences& d);

/// True only if the features are further apart than `distance`: a cheap test that settles most pairs that are coplanar
/// beside each other. `size`: at least the largest coordinate of `d`.
bool clearly_apart(FeatureKind kind, const Differences& d, double distance, double size);

}  // namespace volccd::detail
