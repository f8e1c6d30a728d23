// Cones of directions at a vertex, with certified predicates.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include <volccd/numerics/certified_sign.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// The directions a x + b y + c z with x, y, z > 0. Pre for both predicates: det(a, b, c) > 0; the vectors are exact or
/// rounded differences of points.
struct DirectionCone {
  Vec3 a, b, c;

  bool contains(const Vec3& d) const {
    return certainly_positive(d, b, c) && certainly_positive(a, d, c) && certainly_positive(a, b, d);
  }
  bool excludes(const Vec3& d) const {
    return certainly_negative(d, b, c) || certainly_negative(a, d, c) || certainly_negative(a, b, d);
  }
};

/// Whether, at t = 0, the ring of these directed sides surrounds `up` exactly once as seen from v. Pre: there is a
/// side; for each side (a, b), the normal of the triangle (v, a, b) has a positive dot product with `up`. Projected
/// onto the plane perpendicular to `up`, the sectors of these triangles are narrower than half a turn; the ring
/// surrounds `up` once if a direction in the first sector is in no other.
inline bool winds_once(const Motion& motion, Index v, std::span<const std::array<Index, 2>> sides, const Vec3& up) {
  const Vec3 at = motion.point(v, 0);
  const auto way = [&](Index w) -> Vec3 { return motion.point(w, 0) - at; };
  const Vec3 a = way(sides[0][0]), b = way(sides[0][1]), direction = a + b;
  if (!certainly_positive(up, a, direction) || !certainly_positive(up, direction, b)) return false;
  return std::all_of(sides.begin() + 1, sides.end(), [&](const std::array<Index, 2>& side) {
    return certainly_negative(up, way(side[0]), direction) || certainly_negative(up, direction, way(side[1]));
  });
}

}  // namespace volccd::detail
