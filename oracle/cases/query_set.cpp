#include <volccd/oracle/cases/query_set.hpp>

#include <cassert>
#include <string>
#include <utility>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

Motion motion_of(Index queries, int control_points, std::span<const Vec3> points) {
  Motion motion(4 * queries, control_points);
  std::size_t at = 0;
  for (Index i = 0; i < queries; ++i)
    for (int c = 0; c < control_points; ++c)
      for (Index p = 0; p < 4; ++p, ++at) {
        if (!points[at].allFinite()) throw InputError("queries", "points", i, "a point is not finite");
        motion.set(4 * i + p, c, points[at]);
      }
  return motion;
}

Index query_count(int control_points, std::span<const Vec3> points) {
  assert(control_points == 2 || control_points == 3);
  const std::size_t each = 4 * static_cast<std::size_t>(control_points);
  if (points.size() % each != 0)
    throw InputError("queries", "points",
                     std::to_string(points.size()) + " are no multiple of " + std::to_string(each));
  if (points.size() / each >= kNone / 4)
    throw InputError("queries", "points", "more than " + std::to_string(kNone / 4 - 1) + " queries");
  return static_cast<Index>(points.size() / each);
}

}  // namespace

Mesh separate_tetrahedra(Index count) {
  Mesh mesh;
  mesh.add_vertices(4 * count);
  for (Index i = 0; i < count; ++i)
    mesh.add_element({.type = ElementType::tetrahedron, .vertices = {4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3}, .id = i});
  return mesh;
}

QuerySet::QuerySet(FeatureKind kind, int control_points, std::span<const Vec3> points) : kind_(kind) {
  const Index n = query_count(control_points, points);
  Motion motion = motion_of(n, control_points, points);
  scene_ = std::make_unique<const Scene>(Scene{Topology(separate_tetrahedra(n)), std::move(motion), {}});
  const Features& features = scene_->topology.features();
  pairs_.reserve(n);
  for (Index i = 0; i < n; ++i) {
    const Index v = 4 * i;
    pairs_.push_back(kind == FeatureKind::vf
                         ? FeaturePair{v, features.find_triangle(v + 1, v + 2, v + 3)}
                         : FeaturePair{features.find_edge(v, v + 1), features.find_edge(v + 2, v + 3)});
  }
}

Step QuerySet::step(double t_max, double separation) const {
  return {scene_->topology, scene_->motion, scene_->filter, separation, t_max};
}

}  // namespace volccd
