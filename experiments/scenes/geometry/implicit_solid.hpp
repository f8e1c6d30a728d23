// Solids given by a function, and the operations on them that the scenes need.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include <volccd/numerics/types.hpp>

namespace volccd {

/// The solid is the set of points with `value` < 0. The function is continuous, finite, without side effects, and
/// approximates the signed distance near the surface.
struct ImplicitSolid {
  std::function<double(const Vec3&)> value;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< corners of a box that contains the solid
};

/// The minimum of two values, smoothed where they differ by less than `blend` (> 0): the union of two solids with a
/// fillet of about that size. At most min(a, b), by at most blend / 4.
inline double smooth_union(double a, double b, double blend) {
  const double near = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - near * near * blend / 4;
}

/// The part of solid a that is outside solid b, with a rounded rim.
inline double smooth_difference(double a, double b, double blend) { return -smooth_union(-a, b, blend); }

/// Approximate signed distance to an ellipsoid with half axes `radii` (> 0); exact for a sphere.
inline double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 unit = (p - centre).cwiseQuotient(radii);
  const double length = unit.norm(), slope = unit.cwiseQuotient(radii).norm();
  return slope > 0 ? length * (length - 1) / slope : -radii.minCoeff();
}

}  // namespace volccd
