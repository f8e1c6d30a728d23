// Closest points of the two features of a test at one time. Valid also for features without extent and for parallel
// edges.
#pragma once

#include <array>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/numerics/rounding.hpp>
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

/// The distance of closest_points() is that of two points of the features up to an error of this factor times the sum
/// of the extents, for up to three control points: 12 u per axis, for both features.
inline constexpr double kDistanceError = 40 * kUnitRoundoff;

/// Pre: sizes are in the range of range_scale(). The distance is minimal up to about 1e-15 times the size, also for
/// slivers.
ClosestPoints closest_points(FeatureKind kind, const Differences& d);

/// The direction between the closest points at one time, for projections that separate the features. The difference of
/// these points has an error of about a unit of roundoff of the size. If it is small, its direction is inaccurate, and
/// a plane perpendicular to it may intersect long features that it should separate. Therefore the direction is made
/// perpendicular to the edges and triangles in whose interiors the closest points are. Neither its length nor its sign
/// has a meaning.
Vec3 separating_axis(FeatureKind kind, const Differences& d, const ClosestPoints& closest);

/// Candidates for that direction for features that are nearer than about 2^-26 times their size. For these, rounding
/// determines in which edges the closest points seem to be: the nearest point of a sliver may be a corner although an
/// edge is almost as close. Therefore every choice of edges to which the axis is perpendicular is tried.
std::array<Vec3, 5> close_axes(FeatureKind kind, const Differences& d, const Vec3& separation);

/// True only if the features are further apart than `distance`. This cheap test decides most pairs that are coplanar
/// and side by side. Pre: `size` is at least the largest coordinate of `d`.
bool clearly_apart(FeatureKind kind, const Differences& d, double distance, double size);

}  // namespace volccd::detail
