// Cones of directions at a vertex, with certified predicates.
#pragma once

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

/// Whether, at t = 0, the polygon `ring` surrounds `up` exactly once as seen from v. Pre: for consecutive vertices a
/// and b of the ring, also the last and the first one, the normal of the triangle (v, a, b) has a positive dot product
/// with `up`. Projected onto the plane perpendicular to `up`, the sectors of these triangles are narrower than half a
/// turn; the ring surrounds `up` once if a direction in the first sector is in no other.
inline bool winds_once(const Motion& motion, Index v, std::span<const Index> ring, const Vec3& up) {
  const Vec3 at = motion.point(v, 0);
  const auto side = [&](std::size_t i) -> Vec3 { return motion.point(ring[i < ring.size() ? i : 0], 0) - at; };
  const Vec3 direction = side(0) + side(1);
  if (!certainly_positive(up, side(0), direction) || !certainly_positive(up, direction, side(1))) return false;
  for (std::size_t i = 1; i < ring.size(); ++i)
    if (!certainly_negative(up, side(i), direction) && !certainly_negative(up, direction, side(i + 1))) return false;
  return true;
}

}  // namespace volccd::detail
