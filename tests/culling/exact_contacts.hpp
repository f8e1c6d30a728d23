// Contacts of all features of a small mesh, decided in exact arithmetic.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Geometry>

#include <volccd/mesh/features.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Whether the boxes of the features, with the separation around them, meet at t; for the whole step if t < 0.
inline bool boxes_meet(const Motion& motion, const std::array<Index, 4>& v, std::size_t of_first, double separation,
                       double t = -1) {
  const auto bounds = [&](std::size_t begin, std::size_t end) {
    Eigen::AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i)
      for (int c = 0; c < (t < 0 ? motion.control_points() : 1); ++c) {
        const Vec3 at = t < 0 ? motion.point(v[i], c) : motion.position(v[i], t);
        for (const double d : {-separation, separation}) box.extend(Vec3(at + Vec3(d, d, d)));
      }
    return box;
  };
  return bounds(0, of_first).intersects(bounds(of_first, 4));
}

/// Whether the features come within the separation, in exact arithmetic.
inline bool in_contact(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices) {
  const std::size_t of_first = kind == FeatureKind::vf ? 1 : 2;
  if (!boxes_meet(step.motion, vertices, of_first, step.separation)) return false;
  TestMotion moving{kind, step.motion.control_points(), {}};
  for (std::size_t i = 0; i < 4; ++i) moving.points[i] = step.motion.at(vertices[i]);
  return exact_first_touch(moving, 1, step.separation).touches;
}

/// Calls visit(elements of a, elements of b) for each pair of features without a common vertex that is in contact.
template <class Visit>
void visit_touching(const Step& step, Visit&& visit) {
  const Features& features = step.features();
  const auto touches = [&](FeatureKind kind, FeaturePair test) {
    return is_test(features, kind, test) && in_contact(step, kind, test_vertices(features, kind, test));
  };
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.vertex_elements(v).empty() && !features.triangle_elements(f).empty() &&
          touches(FeatureKind::vf, {v, f}))
        visit(features.vertex_elements(v), features.triangle_elements(f));
  for (Index e = 0; e < features.edge_slots(); ++e)
    for (Index g = 0; g < e; ++g)
      if (!features.edge_elements(e).empty() && !features.edge_elements(g).empty() && touches(FeatureKind::ee, {g, e}))
        visit(features.edge_elements(g), features.edge_elements(e));
}

}  // namespace volccd::detail
