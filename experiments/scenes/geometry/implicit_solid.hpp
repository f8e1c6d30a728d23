// Solids given by a function, and the few ways of putting them together that the scenes need.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include <volccd/mesh/types.hpp>

namespace volccd {

/// What is inside: where `value` < 0. The function is continuous, finite, without side effects, and about a distance
/// near the surface.
struct ImplicitSolid {
  std::function<double(const Vec3&)> value;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< corners of a box that holds the solid
};

/// Smaller of two values, its kink rounded where they differ by less than `blend` (> 0): the union of two solids with a
/// fillet of about that size. At most min(a, b), by at most blend / 4.
inline double smooth_union(double a, double b, double blend) {
  const double near = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - near * near * blend / 4;
}

/// The part of solid a that is outside solid b, its rim rounded.
inline double smooth_difference(double a, double b, double blend) { return -smooth_union(-a, b, blend); }

/// About the distance to an ellipsoid with half axes `radii` (> 0); exact for a sphere.
inline double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 unit = (p - centre).cwiseQuotient(radii);
  const double length = unit.norm(), slope = unit.cwiseQuotient(radii).norm();
  return slope > 0 ? length * (length - 1) / slope : -radii.minCoeff();
}

}  // namespace volccd
