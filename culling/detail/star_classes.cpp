#include <volccd/culling/detail/star_classes.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <volccd/culling/detail/direction_cones.hpp>
#include <volccd/culling/detail/volume_signs.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kElementGrain = 1024, kVertexGrain = 256;

/// The directions from v into a tetrahedron at t = 0.
DirectionCone cone_at(const Step& step, Index o, Index v, bool mirrored) {
  const std::span<const Index> t = step.topology.adjacency().vertices(o);
  const auto i = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
  const std::array<Index, 3> others = StarTable::face_of(t, i);
  const Vec3 at = step.motion.point(v, 0);
  return {step.motion.point(others[0], 0) - at, step.motion.point(others[mirrored ? 2 : 1], 0) - at,
          step.motion.point(others[mirrored ? 1 : 2], 0) - at};
}

/// Whether the tetrahedra around v, all of non-zero volume at t = 0, surround it exactly once. This holds if a
/// direction in the first tetrahedron is in no other.
bool goes_once_around(const Step& step, Index v, const std::vector<std::int8_t>& signs) {
  const std::span<const Index> star = step.features().vertex_elements(v);
  const DirectionCone first = cone_at(step, star[0], v, signs[star[0]] < 0);
  const Vec3 direction = first.a + first.b + first.c;
  if (!first.contains(direction)) return false;
  return std::all_of(star.begin() + 1, star.end(),
                     [&](Index o) { return cone_at(step, o, v, signs[o] < 0).excludes(direction); });
}

}  // namespace

void StarClasses::find_degenerate(const Step& step, const StarTable& stars, Executor& executor) {
  const Index slots = step.mesh().element_slots();
  signs_.resize(slots);
  degenerate_.resize(slots);
  regular_.resize(slots);
  executor.parallel_for(slots, kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    volume_signs(step, static_cast<Index>(begin), static_cast<Index>(end), signs_.data());
  });
  const bool negative = std::find(signs_.begin(), signs_.end(), std::int8_t{-1}) != signs_.end();
  executor.parallel_for(slots, kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t o = begin; o < end; ++o) {
      const StarTable::Fit fit =
          negative ? fit_with_signs(stars, static_cast<Index>(o)) : stars.fit(static_cast<Index>(o));
      degenerate_[o] = signs_[o] == 0 || fit == StarTable::Fit::folded ? 1 : 0;
      regular_[o] = signs_[o] != 0 && fit == StarTable::Fit::regular ? 1 : 0;
    }
  });
}

/// How a tetrahedron fits to its neighbours if the signs of volumes differ. A neighbour without a sign is in D itself.
StarTable::Fit StarClasses::fit_with_signs(const StarTable& stars, Index o) const {
  if (stars.fit(o) == StarTable::Fit::other && !stars.shares_a_face_with_several(o)) return StarTable::Fit::other;
  for (const StarTable::Neighbour& across : stars.neighbours(o))
    if (across.element != kNone && signs_[o] * signs_[across.element] == (across.opposite ? -1 : 1))
      return StarTable::Fit::folded;
  return stars.shares_a_face_with_several(o) ? StarTable::Fit::other : StarTable::Fit::regular;
}

/// The known property of a star (that the star and its ring surround the vertex once) can change only at times when one
/// of its volumes is 0 or its ring folds, or by a change of the topology. If this step does not begin with the end
/// positions of the last one, the property is kept if neither occurs on the straight motion between them.
void StarClasses::keep_known(const Step& step, const StarTable& stars, TopologyDelta::Extent changed,
                             Executor& executor) {
  const Index vertices = step.motion.vertex_count();
  const bool anew = changed == TopologyDelta::Extent::everything || gap_.empty();
  if (anew) {
    embedded_.assign(vertices, Known::no);
    gap_.clear();  // of another topology, which may have had more vertices
  }
  embedded_.resize(vertices, Known::no);
  if (changed == TopologyDelta::Extent::edits)
    for (const Index v : stars.changed_vertices()) embedded_[v] = Known::no;
  if (!gap_.update(step.motion, executor)) return;
  const Step way{step.topology, gap_.way(), step.filter};
  gap_signs_.resize(signs_.size());
  executor.parallel_for(signs_.size(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    volume_signs(way, static_cast<Index>(begin), static_cast<Index>(end), gap_signs_.data());
  });
  for (Index o = 0; o < signs_.size(); ++o)
    if (signs_[o] != 0 && gap_signs_[o] != signs_[o]) forget_around(step, o);  // update() does for those in D
  rings_.find_folds(way, executor, folds_);
  for (Index v = 0; v < vertices; ++v)
    if (folds_[v] != 0) embedded_[v] = Known::no;
}

void StarClasses::forget_around(const Step& step, Index element) {
  for (const Index v : step.mesh().vertices(element)) embedded_[v] = Known::no;
}

void StarClasses::classify(const Step& step, const StarTable& stars, Index v, StarTable::Ring& scratch) {
  if (stars.kind(v) == StarKind::unused || suspect_[v] != 0) return;
  const bool ring = stars.kind(v) == StarKind::ring;
  if (ring && folds_[v] != 0) {
    suspect_[v] = 1;
    embedded_[v] = Known::no;
    return;
  }
  if (embedded_[v] == Known::yes) return;
  const bool volumes = step.mesh().type(step.features().vertex_elements(v)[0]) == ElementType::tetrahedron;
  const bool around = !volumes || goes_once_around(step, v, signs_);
  wound_[v] = !around && !ring ? 1 : 0;
  if (around && (!ring || winds_once(step.motion, v, stars.ring(step.topology, v, scratch), rings_.up(v))))
    embedded_[v] = Known::yes;
  else
    suspect_[v] = 1;
}

void StarClasses::update(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor) {
  if (!complete_) changed = TopologyDelta::Extent::everything;  // the last update was interrupted: nothing is known
  complete_ = false;
  find_degenerate(step, stars, executor);
  if (changed != TopologyDelta::Extent::none) rings_.set_faces(step.mesh(), stars.boundary_faces(step.topology));
  keep_known(step, stars, changed, executor);
  rings_.find_folds(step, executor, folds_);
  const Index vertices = step.motion.vertex_count();
  suspect_.resize(vertices);
  wound_.assign(vertices, 0);
  for (Index v = 0; v < vertices; ++v) suspect_[v] = stars.kind(v) == StarKind::irregular ? 1 : 0;
  degenerate_count_ = 0;
  for (Index o = 0; o < degenerate_.size(); ++o) {
    if (degenerate_[o] == 0) continue;
    ++degenerate_count_;
    forget_around(step, o);
    for (const Index v : step.mesh().vertices(o)) suspect_[v] = 1;
  }
  scratch_.resize(executor.workers());
  executor.parallel_for(vertices, kVertexGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t v = begin; v < end; ++v) classify(step, stars, static_cast<Index>(v), scratch_[w]);
  });
  wound_count_ = static_cast<std::size_t>(std::count(wound_.begin(), wound_.end(), std::uint8_t{1}));
  suspects_.clear();
  for (Index v = 0; v < vertices; ++v)
    if (suspect_[v] != 0) suspects_.push_back(v);
  suspect_places_.assign(signs_.size(), 0);
  for (const Index v : suspects_)
    for (const Index o : step.features().vertex_elements(v)) {
      const std::span<const Index> corners = step.topology.adjacency().vertices(o);
      for (std::size_t i = 0; i < 4; ++i)
        suspect_places_[o] |= static_cast<std::uint8_t>((corners[i] == v ? 1 : 0) << i);
    }
  complete_ = true;
}

std::size_t StarClasses::bytes() const {
  std::size_t scratch = 0;
  for (const StarTable::Ring& ring : scratch_) scratch += ring.bytes();
  return scratch + signs_.capacity() + gap_signs_.capacity() + degenerate_.capacity() + regular_.capacity() +
         suspect_.capacity() + suspect_places_.capacity() + wound_.capacity() + embedded_.capacity() +
         folds_.capacity() + rings_.bytes() + gap_.bytes() + suspects_.capacity() * sizeof(Index);
}

}  // namespace volccd::detail
