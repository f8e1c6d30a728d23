// Axes L for CSAT tests. Any vector is a valid axis; therefore no error bounds are needed here.
#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#include <volccd/core/random.hpp>
#include <volccd/culling/csat/csat_points.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The hash that picks a feature of element o for its tests with element `other`. `feature`: 0 for a face, 1 for an
/// edge.
inline std::uint64_t csat_pick(const Step& step, Index o, Index other, int feature) {
  const std::uint64_t ids = hash_ids(static_cast<std::uint64_t>(step.mesh().element_id(o)),
                                     static_cast<std::uint64_t>(step.mesh().element_id(other)));
  return mix(ids ^ static_cast<std::uint64_t>(feature));
}

/// Scales the vector so that its largest component is 1, and products with lengths are unlikely to overflow or
/// underflow. The result is not finite for the zero vector.
inline Vec3 csat_scaled(const Vec3& axis) { return axis * (1 / axis.lpNorm<Eigen::Infinity>()); }

/// Normal at t = 0 of the face of element o that `hash` selects.
inline Vec3 csat_face_normal(const Step& step, Index o, std::uint64_t hash) {
  const auto faces = step.features().element_triangles(o);
  const auto& f = step.features().triangle(faces[hash % faces.size()]);
  const Vec3 p = step.motion.point(f[0], 0);
  return csat_scaled((step.motion.point(f[1], 0) - p).cross(step.motion.point(f[2], 0) - p));
}

/// Direction at t = 0 of the edge of element o that `hash` selects.
inline Vec3 csat_picked_edge(const Step& step, Index o, std::uint64_t hash) {
  const auto edges = step.features().element_edges(o);
  const auto& edge = step.features().edge(edges[hash % edges.size()]);
  return step.motion.point(edge[1], 0) - step.motion.point(edge[0], 0);
}

/// Mean of the vertices at one control point.
inline Vec3 csat_mean(const CsatPoints& points, int control_point) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < points.count; ++i)
    for (int k = 0; k < 3; ++k) sum[k] += points.at(control_point, k, i);
  return sum / points.count;
}

/// The vector from the mean of all control points of `a` to that of `b`. It is a point of the convex hull of the
/// differences.
inline Vec3 csat_centroid_difference(const CsatPoints& a, const CsatPoints& b, int control_points) {
  const double of_a = 1.0 / (control_points * a.count), of_b = 1.0 / (control_points * b.count);
  return {b.total[0] * of_b - a.total[0] * of_a, b.total[1] * of_b - a.total[1] * of_a,
          b.total[2] * of_b - a.total[2] * of_a};
}

/// Direction of the mean motion of `b` relative to `a`.
inline Vec3 csat_velocity_axis(const CsatPoints& a, const CsatPoints& b, int control_points) {
  const int last = control_points - 1;
  return csat_scaled((csat_mean(b, last) - csat_mean(b, 0)) - (csat_mean(a, last) - csat_mean(a, 0)));
}

}  // namespace volccd::detail
