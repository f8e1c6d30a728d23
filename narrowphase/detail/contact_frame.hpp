// From a time and weights to a Contact: normal and point.
#pragma once

#include <volccd/narrowphase/detail/closest_points.hpp>

namespace volccd::detail {

/// Unit normal at t from the second feature towards the first as it was before. `side`: the sign of the coplanarity
/// cubic before the contact, where the features are on different sides of their common plane; 0 if they were in one
/// plane, then it is the direction of their separation shortly before. Zero if that does not tell either.
Vec3 contact_normal(FeatureKind kind, const MovingPoints& points, double t, int side);

/// The point with these weights on the second feature, at t.
Vec3 contact_point(FeatureKind kind, const TestPoints& x, double t, const std::array<double, 4>& weights);

}  // namespace volccd::detail
