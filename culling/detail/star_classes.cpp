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

void StarClasses::find_signs(const Step& step, std::vector<std::int8_t>& signs, Executor& executor) const {
  signs.resize(step.mesh().element_slots());
  executor.parallel_for(signs.size(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    volume_signs(step, static_cast<Index>(begin), static_cast<Index>(end), signs.data());
  });
}

void StarClasses::find_degenerate(const Step& step, const StarTable& stars, Executor& executor) {
  const Index slots = step.mesh().element_slots();
  find_signs(step, signs_, executor);
  degenerate_.resize(slots);
  regular_.resize(slots);
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

void StarClasses::classify(const Step& step, const StarTable& stars, Index v, Ring& scratch) {
  if (stars.kind(v) == StarKind::unused || suspect_[v] != 0) return;
  const bool ring = stars.kind(v) == StarKind::ring;
  if (ring && folds_[v] != 0) {
    suspect_[v] = 1;
    known_[v] = 0;
    return;
  }
  if (known_[v] != 0) return;
  const bool volumes = step.mesh().type(step.features().vertex_elements(v)[0]) == ElementType::tetrahedron;
  const bool around = !volumes || goes_once_around(step, v, signs_);
  wound_[v] = !around && !ring ? 1 : 0;
  if (around && (!ring || winds_once(step.motion, v, stars.ring(step.topology, v, scratch), rings_.up(v))))
    known_[v] = 1;
  else
    suspect_[v] = 1;
}

void StarClasses::update(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor) {
  changed = begin(changed);
  find_degenerate(step, stars, executor);
  keep_known(step, stars, changed, executor, [&](const Step& way) {
    find_signs(way, gap_signs_, executor);
    for (Index o = 0; o < signs_.size(); ++o)
      if (signs_[o] != 0 && gap_signs_[o] != signs_[o]) forget(step.mesh().vertices(o));  // those in D are below
  });
  const Index vertices = step.motion.vertex_count();
  wound_.assign(vertices, 0);
  for (Index v = 0; v < vertices; ++v) suspect_[v] = stars.kind(v) == StarKind::irregular ? 1 : 0;
  degenerate_count_ = 0;
  for (Index o = 0; o < degenerate_.size(); ++o) {
    if (degenerate_[o] == 0) continue;
    ++degenerate_count_;
    forget(step.mesh().vertices(o));
    for (const Index v : step.mesh().vertices(o)) suspect_[v] = 1;
  }
  executor.parallel_for(vertices, kVertexGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t v = begin; v < end; ++v) classify(step, stars, static_cast<Index>(v), scratch_[w]);
  });
  wound_count_ = static_cast<std::size_t>(std::count(wound_.begin(), wound_.end(), std::uint8_t{1}));
  finish();
  suspect_places_.assign(signs_.size(), 0);
  for (const Index v : suspects())
    for (const Index o : step.features().vertex_elements(v)) {
      const std::span<const Index> corners = step.topology.adjacency().vertices(o);
      for (std::size_t i = 0; i < 4; ++i)
        suspect_places_[o] |= static_cast<std::uint8_t>((corners[i] == v ? 1 : 0) << i);
    }
}

}  // namespace volccd::detail
