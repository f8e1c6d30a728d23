#include <volccd/culling/stars/star_classifier.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include <volccd/culling/stars/detail/direction_cones.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kElementGrain = 1024, kStarGrain = 256;

/// The place of the vertex of smallest slot in an element.
std::size_t min_vertex(std::span<const Index> vertices) {
  return static_cast<std::size_t>(std::min_element(vertices.begin(), vertices.end()) - vertices.begin());
}

/// The bits of all vertices of an element (ConeSigns), or 0 if it has too many.
unsigned all_bits(std::span<const Index> vertices) { return vertices.size() <= 8 ? (1u << vertices.size()) - 1 : 0; }

/// Calls visit(cone) for the cones of directions from v into the elements at v, at t = 0: one for each boundary
/// triangle on a face without v.
template <class Visit>
void visit_cones(const Step& step, Index v, bool mirrored, Visit&& visit) {
  const Vec3 at = step.motion.point(v, 0);
  const auto visit_triangle = [&](Index a, Index b, Index c) {
    const auto way = [&](Index w) -> Vec3 { return step.motion.point(w, 0) - at; };
    visit(DirectionCone{way(a), way(mirrored ? c : b), way(mirrored ? b : c)});
  };
  for (const Index o : step.features().vertex_elements(v)) {
    if (step.mesh().type(o) == ElementType::tetrahedron) {
      const std::span<const Index> vertices = step.mesh().vertices(o);
      const auto i = static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
      const std::array<Index, 3> face = face_opposite(vertices, i);
      visit_triangle(face[0], face[1], face[2]);
      continue;
    }
    visit_faces(step.mesh(), o, [&](std::span<const Index> face, std::size_t) {
      if (std::find(face.begin(), face.end(), v) != face.end()) return;
      const auto first = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
      const auto vertex = [&](std::size_t i) { return face[(first + i) % face.size()]; };
      for (std::size_t i = 1; i + 1 < face.size(); ++i) visit_triangle(vertex(0), vertex(i), vertex(i + 1));
    });
  }
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

void StarClassifier::find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const {
  signs.resize(step.mesh().element_slots());
  executor.parallel_for(signs.size(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    cone_signs(step, static_cast<Index>(begin), static_cast<Index>(end), signs.data());
  });
}

/// Nearly all elements of most meshes have positive cones, so that this pass writes hardly anything.
void StarClassifier::find_all_positive(const Step& step, Executor& executor) {
  all_positive_.assign(step.motion.vertex_count(), 1);
  executor.parallel_for(signs_.size(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t o = begin; o < end; ++o) {
      const std::span<const Index> vertices = step.mesh().vertices(static_cast<Index>(o));
      const unsigned positive = signs_[o].positive, all = all_bits(vertices);
      if (positive == all && all != 0) continue;
      const bool inverted = all == 0 || (positive >> min_vertex(vertices) & 1) == 0;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        if (inverted || (positive >> i & 1) == 0)
          std::atomic_ref(all_positive_[vertices[i]]).store(0, std::memory_order_relaxed);
    }
  });
}

/// Invalidates what is known of condition 4 for stars that changed, or may have folded between the last step and this
/// one. Those that may fold in this step follow in examine_star().
void StarClassifier::invalidate_known(const Step& step, const Motion* gap, Executor& executor) {
  known_.resize(step.motion.vertex_count(), Known::nothing);
  for (const Index v : table_.changed_vertices()) known_[v] = Known::nothing;
  if (!gap) return;
  const Step between{step.topology, *gap, step.filter};
  rings_.find_folds(between, executor, folds_);
  for (std::size_t v = 0; v < known_.size(); ++v)
    if (folds_[v] != 0) known_[v] = Known::nothing;
  find_signs(between, gap_signs_, executor);
  for (Index o = 0; o < signs_.size(); ++o)  // stars that need the other signs are suspect in this step
    if (!gap_signs_[o].include(signs_[o]))
      for (const Index v : step.mesh().vertices(o)) known_[v] = Known::nothing;
}

/// The common sign of the cones at v and of the tetrahedra of the elements at v, throughout the step; 0 if there is
/// none. The tetrahedra of an element are the cone of its vertex of smallest slot.
int StarClassifier::proven_sign(const Step& step, Index v) const {
  if (all_positive_[v] != 0) return 1;
  bool positive = true, negative = true;
  for (const Index o : step.features().vertex_elements(v)) {
    const std::span<const Index> vertices = step.mesh().vertices(o);
    const auto place = static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
    const unsigned bits = 1u << place | 1u << min_vertex(vertices);
    positive = positive && (signs_[o].positive & bits) == bits;
    negative = negative && (signs_[o].negative & bits) == bits;
  }
  return positive ? 1 : negative ? -1 : 0;
}

/// Condition 4. For shells only the ring has to go around once.
bool StarClassifier::surrounds_once(const Step& step, Index v, int sign, RingSides& scratch) const {
  if (table_.kind(v) == StarKind::interior) return cones_go_once_around(step, v, sign < 0);
  const Vec3 up = rings_.up(v);
  return winds_once(step.motion, v, table_.ring(step.topology, v, scratch), up) &&
         (StarTable::has_shells(step.topology, v) || cones_exclude(step, v, sign < 0, sign * up));
}

bool StarClassifier::examine_star(const Step& step, Index v, RingSides& scratch) {
  const StarKind kind = table_.kind(v);
  const bool excluded = kind == StarKind::irregular || (kind == StarKind::ring && folds_[v] != 0);
  const int sign = excluded ? 0 : proven_sign(step, v);
  if (sign == 0) {
    known_[v] = Known::nothing;
    return false;
  }
  if (known_[v] == Known::nothing)
    known_[v] = surrounds_once(step, v, sign, scratch) ? Known::surrounded : Known::not_proven;
  return known_[v] == Known::surrounded;
}

void StarClassifier::set_judged(const Step& step, std::vector<Index> vertices) {
  std::vector<std::uint8_t> is_judged(step.motion.vertex_count(), 0);
  for (const Index v : vertices) is_judged[v] = 1;
  for (const Index v : judged_)
    if (v < known_.size() && (v >= is_judged.size() || is_judged[v] == 0)) known_[v] = Known::nothing;
  judged_ = std::move(vertices);
  rings_.set_faces(step.mesh(), table_.boundary_faces(step.topology, is_judged));
}

void StarClassifier::classify(const Step& step, const Motion* gap, Executor& executor) {
  find_signs(step, signs_, executor);
  find_all_positive(step, executor);
  invalidate_known(step, gap, executor);
  rings_.find_folds(step, executor, folds_);
  suspect_.resize(step.motion.vertex_count());
  scratch_.resize(executor.workers());
  executor.parallel_for(judged_.size(), kStarGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i)
      suspect_[judged_[i]] = examine_star(step, judged_[i], scratch_[w]) ? 0 : 1;
  });
}

}  // namespace volccd::detail
