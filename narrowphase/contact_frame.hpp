// Computes a Contact, with normal and point, from a time and weights.
#pragma once

#include <volccd/narrowphase/closest_points.hpp>
#include <volccd/query/contact.hpp>

namespace volccd::detail {

/// Unit normal directed from the second feature towards the position of the first feature before the contact. `side` is
/// the sign of the coplanarity polynomial before the contact. If it is 0, the features were coplanar, and the normal is
/// the direction of their separation shortly before the contact. The result is zero if that direction is undetermined,
/// too. `touching` and `before` are the differences at the time of contact and kBefore earlier; `size` is the size of
/// the test.
Vec3 contact_normal(FeatureKind kind, const Differences& touching, const Differences& before, double size, int side);

/// Time difference for the separation before the contact.
inline constexpr double kBefore = 0x1p-12;

/// Normal of the contact at t. `Points` is MovingPoints or CurvedPoints.
template <class Points>
Vec3 contact_normal(FeatureKind kind, const Points& points, double t, int side) {
  return contact_normal(kind, points.at(t), points.at(t - kBefore), points.size, side);
}

/// The point with these weights on the second feature, at t.
Vec3 contact_point(FeatureKind kind, const TestPoints& x, double t, const std::array<double, 4>& weights,
                   int control_points = 2);

/// The contact of two features that touch at t, as far as doubles can determine, at their closest points. With a
/// `separation`, the normal is the direction between the closest points.
Contact contact_at(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x, int control_points,
                   double t, int side, double separation = 0);

/// The closest points of the features of a test at one time.
struct ScaledClosestPoints {
  ClosestPoints points;
  double size;   ///< of the test; both are multiplied by the scale
  double scale;  ///< as in moving_points()
};

/// The same contact for a separation, from closest points at t that are known.
Contact contact_near(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x, int control_points,
                     double t, const ScaledClosestPoints& closest);

/// The closest points of two features at t = 1.
ContactEnd contact_end(FeatureKind kind, const TestPoints& x, int control_points);

}  // namespace volccd::detail
