// From a time and weights to a Contact: normal and point.
#pragma once

#include <volccd/narrowphase/detail/closest_points.hpp>
#include <volccd/query/contact.hpp>

namespace volccd::detail {

/// Unit normal from the second feature towards the first as it was before the contact. `side`: the sign of the
/// coplanarity polynomial before the contact, where the features are on different sides of their common plane; 0 if
/// they were in one plane, then it is the direction of their separation shortly before. Zero if that does not tell
/// either. `touching`, `before`: at the time of contact and kBefore earlier; `size`: of the test.
Vec3 contact_normal(FeatureKind kind, const Differences& touching, const Differences& before, double size, int side);

/// How long before the contact a separation is looked at.
inline constexpr double kBefore = 0x1p-12;

/// At t. Points: MovingPoints or CurvedPoints.
template <class Points>
Vec3 contact_normal(FeatureKind kind, const Points& points, double t, int side) {
  return contact_normal(kind, points.at(t), points.at(t - kBefore), points.size, side);
}

/// The point with these weights on the second feature, at t.
Vec3 contact_point(FeatureKind kind, const TestPoints& x, double t, const std::array<double, 4>& weights,
                   int control_points = 2);

/// The contact at t of features that touch then, as far as doubles can tell: at their closest points. With a
/// `separation`, the normal is the direction between these.
Contact contact_at(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x, int control_points,
                   double t, int side, double separation = 0);

}  // namespace volccd::detail
