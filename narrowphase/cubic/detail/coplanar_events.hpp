// Degenerate tests: the first contact of features that are coplanar over a time interval.
#pragma once

#include <optional>

#include <volccd/narrowphase/closest_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

struct Touch {
  double t;
  ClosestPoints closest;
};

/// The first time in [lo, hi] at which the features are within `distance` of each other. Pre: the four points are
/// (nearly) coplanar in the whole interval. Coplanar features can begin to touch only at lo or when three points become
/// collinear, and collinear features only when two points meet. Each of these events is a common root of three
/// quadratic or linear functions (one per axis; some may vanish). All roots are examined in ascending order; the
/// distance decides whether the features touch. `slack`: by how much rounding may move a root out of the interval.
std::optional<Touch> first_coplanar_touch(FeatureKind kind, const MovingPoints& points, double lo, double hi,
                                          double distance, double slack);

/// True only if a plane perpendicular to the line of the features' centroids keeps them further apart than `distance`
/// during all of [0,1].
bool centroid_axis_separates(FeatureKind kind, const MovingPoints& points, double distance);

}  // namespace volccd::detail
