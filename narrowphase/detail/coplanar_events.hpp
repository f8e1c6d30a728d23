// Degenerate tests: the first contact of features that stay coplanar over a stretch of time.
#pragma once

#include <optional>

#include <volccd/narrowphase/detail/closest_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

struct Touch {
  double t;
  ClosestPoints closest;
};

/// The first time in [lo, hi] at which the features are within `distance` of each other, given that the four points are
/// (nearly) coplanar all along. While coplanar, features can begin to touch only at lo or when three points become
/// collinear, and collinear ones only when two of them meet: each is a root of three quadratics or linear functions (a
/// component for each axis, of which some may vanish). All roots are looked at, in ascending order; whether they touch
/// there is decided by distance. `slack`: how far outside of the stretch a root may be due to rounding.
std::optional<Touch> first_coplanar_touch(FeatureKind kind, const MovingPoints& points, double lo, double hi,
                                          double distance, double slack);

/// True only if a plane across the line of the features' centroids keeps them further apart than `distance` during all
/// of [0,1].
bool centroid_axis_separates(FeatureKind kind, const MovingPoints& points, double distance);

}  // namespace volccd::detail
