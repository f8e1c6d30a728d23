// Closest points of the two features of a test at one time. Valid also for features without extent and for parallel
// edges.
#pragma once

#include <array>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

struct ClosestPoints {
  /// As in Contact: VF {1, w0, w1, w2}, EE {1-s, s, 1-u, u}; not negative.
  std::array<double, 4> weights;
  /// The vector from the second feature to the first, computed from the weights. Whatever the rounding errors of the
  /// weights are, its length is the distance of two points of the features.
  Vec3 separation;
  double squared_distance;
};

/// The vector from the point of the second feature with these weights to that of the first.
inline Vec3 separation_of(FeatureKind kind, const Differences& d, const std::array<double, 4>& weights) {
  return kind == FeatureKind::vf ? Vec3(-(weights[1] * d[0] + weights[2] * d[1] + weights[3] * d[2]))
                                 : Vec3(weights[1] * d[0] - (weights[2] * d[1] + weights[3] * d[2]));
}

/// Pre: sizes are in the range of range_scale(). The distance is minimal up to about 1e-15 times the size, also for
/// slivers.
ClosestPoints closest_points(FeatureKind kind, const Differences& d);

/// True only if the features are further apart than `distance`. This cheap test decides most pairs that are coplanar
/// and side by side. Pre: `size` is at least the largest coordinate of `d`.
bool clearly_apart(FeatureKind kind, const Differences& d, double distance, double size);

}  // namespace volccd::detail
