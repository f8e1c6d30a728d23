#include <volccd/culling/detail/element_stars.hpp>

#include <algorithm>
#include <array>
#include <atomic>

#include <volccd/culling/detail/direction_cones.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kConeElements = 1024, kStarVertices = 256;

/// The place of the vertex of smallest slot in an element.
std::size_t least_vertex(std::span<const Index> vertices) {
  return static_cast<std::size_t>(std::min_element(vertices.begin(), vertices.end()) - vertices.begin());
}

/// The common sign of the cones at v and of the tetrahedra of the elements at v (docs/boundary_flood.md), throughout
/// the step; 0 if there is none. The tetrahedra of an element are the cone of its vertex of smallest slot.
int common_sign(const Step& step, Index v, const std::vector<ConeSigns>& signs) {
  bool positive = true, negative = true;
  for (const Index o : step.features().vertex_elements(v)) {
    const std::span<const Index> vertices = step.mesh().vertices(o);
    const auto place = static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
    const unsigned bits = 1u << place | 1u << least_vertex(vertices);
    positive = positive && (signs[o].positive & bits) == bits;
    negative = negative && (signs[o].negative & bits) == bits;
  }
  return positive ? 1 : negative ? -1 : 0;
}

/// Calls visit(cone) for the cones of directions from v into the elements at v, at t = 0: one for each boundary
/// triangle on a face without v.
template <class Visit>
void visit_cones(const Step& step, Index v, bool mirrored, Visit&& visit) {
  const Vec3 at = step.motion.point(v, 0);
  for (const Index o : step.features().vertex_elements(v))
    visit_faces(step.mesh(), o, [&](std::span<const Index> face, std::size_t) {
      if (std::find(face.begin(), face.end(), v) != face.end()) return;
      const auto first = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
      const auto way = [&](std::size_t i) -> Vec3 {
        return step.motion.point(face[(first + i) % face.size()], 0) - at;
      };
      for (std::size_t i = 1; i + 1 < face.size(); ++i)
        visit(DirectionCone{way(0), way(mirrored ? i + 1 : i), way(mirrored ? i : i + 1)});
    });
}

/// Whether the cones at v surround it exactly once: a direction in the first one is in no other.
bool cones_go_once_around(const Step& step, Index v, bool mirrored) {
  bool first = true, once = true;
  Vec3 direction;
  visit_cones(step, v, mirrored, [&](const DirectionCone& cone) {
    if (first) direction = cone.a + cone.b + cone.c;
    once = once && (first ? cone.contains(direction) : cone.excludes(direction));
    first = false;
  });
  return once;
}

/// Whether the direction `up` is in no cone at v.
bool cones_exclude(const Step& step, Index v, bool mirrored, const Vec3& up) {
  bool none = true;
  visit_cones(step, v, mirrored, [&](const DirectionCone& cone) { none = none && cone.excludes(up); });
  return none;
}

}  // namespace

void ElementStars::find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const {
  signs.resize(step.mesh().element_slots());
  executor.parallel_for(signs.size(), kConeElements, [&](std::size_t begin, std::size_t end, unsigned) {
    cone_signs(step, static_cast<Index>(begin), static_cast<Index>(end), signs.data());
  });
}

/// Nearly all elements of most meshes have positive cones, so that this pass writes hardly anything.
void ElementStars::find_all_positive(const Step& step, Executor& executor) {
  all_positive_.assign(step.motion.vertex_count(), 1);
  executor.parallel_for(signs_.size(), kConeElements, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t o = begin; o < end; ++o) {
      const std::span<const Index> vertices = step.mesh().vertices(static_cast<Index>(o));
      const unsigned all = (1u << std::min<std::size_t>(8, vertices.size())) - 1;
      if (signs_[o].positive == all && vertices.size() <= 8) continue;
      const bool inverted = vertices.size() > 8 || (signs_[o].positive >> least_vertex(vertices) & 1) == 0;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        if (inverted || (signs_[o].positive >> i & 1) == 0)
          std::atomic_ref(all_positive_[vertices[i]]).store(0, std::memory_order_relaxed);
    }
  });
}

bool ElementStars::is_clear(const Step& step, Index v, Ring& scratch) {
  const bool ring = table_.kind(v) == StarKind::ring;
  const bool excluded = table_.kind(v) == StarKind::irregular || (ring && folds_[v] != 0);
  const int sign = excluded ? 0 : all_positive_[v] != 0 ? 1 : common_sign(step, v, signs_);
  if (sign == 0) {
    known_[v] = 0;
    return false;
  }
  if (known_[v] != 0) return true;
  const bool once = ring ? winds_once(step.motion, v, table_.ring(step.topology, v, scratch), rings_.up(v)) &&
                               cones_exclude(step, v, sign < 0, sign * rings_.up(v))
                         : cones_go_once_around(step, v, sign < 0);
  if (once) known_[v] = 1;
  return once;
}

void ElementStars::update(const Step& step, Executor& executor) {
  const TopologyDelta::Extent changed = begin(table_.update(step.topology, executor));
  find_signs(step, signs_, executor);
  find_all_positive(step, executor);
  keep_known(step, table_, changed, executor, [&](const Step& way) {
    find_signs(way, gap_signs_, executor);
    for (Index o = 0; o < signs_.size(); ++o)  // stars that need the other signs are suspect in this step
      if (!gap_signs_[o].include(signs_[o])) forget(step.mesh().vertices(o));
  });
  executor.parallel_for(suspect_.size(), kStarVertices, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index v = static_cast<Index>(i);
      suspect_[v] = table_.kind(v) != StarKind::unused && !is_clear(step, v, scratch_[w]) ? 1 : 0;
    }
  });
  finish();
}

}  // namespace volccd::detail
