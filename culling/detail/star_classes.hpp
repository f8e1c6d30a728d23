// Which parts of a simplicial complex stay embedded all through a step, and which may fold: D, clear and suspect stars.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/boundary_rings.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Classifies the elements and vertices of the complex for one step (docs/boundary_flood.md). All predicates are
/// certified: rounding may only move an element into D, or make a star suspect. One thread at a time; uses the
/// executor.
class StarClasses {
 public:
  /// `changed`: what StarTable::update() returned for this topology.
  void update(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor);

  /// In D: a tetrahedron whose volume is not proven to keep one sign, or that has a face whose two tetrahedra are not
  /// proven to lie on different sides of it.
  bool degenerate(Index o) const { return degenerate_[o] != 0; }
  std::size_t degenerate_count() const { return degenerate_count_; }
  /// Not clear: the map of the star to space is not proven injective at all times of the step.
  bool suspect(Index v) const { return suspect_[v] != 0; }
  const std::vector<Index>& suspects() const { return suspects_; }  ///< ascending
  /// An interior vertex whose star is in one piece, not in D, and not proven to go once around the vertex.
  bool wound(Index v) const { return wound_[v] != 0; }

  /// Bits of the places at which the vertices of simplex a are vertices of b (Adjacency::vertices, a triangle repeats
  /// its first one).
  static std::uint32_t common_vertices(const Topology& topology, Index a, Index b) {
    const Index *x = topology.adjacency().vertices(a).data(), *y = topology.adjacency().vertices(b).data();
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i)
      bits |= std::uint32_t{x[i] == y[0] || x[i] == y[1] || x[i] == y[2] || x[i] == y[3]} << i;
    return bits;
  }
  /// The same, 0 if a and b are proven to have no two points of the complex in one place at any time: one of the common
  /// vertices has a clear star, or they are tetrahedra out of D, the same or on both sides of a face that no other has.
  std::uint32_t common_suspects(const Topology& topology, Index a, Index b) const {
    const std::uint32_t common = common_vertices(topology, a, b);
    if ((common & ~std::uint32_t{suspect_places_[a]}) != 0) return 0;
    const std::uint32_t but_one = common & (common - 1);
    const bool three = (but_one & (but_one - 1)) != 0;
    return sound_[a] != 0 && sound_[b] != 0 && three ? 0 : common;
  }
  /// The first of them in the order of a's vertices, kNone if there is none: pairs in a suspect star are visited once,
  /// at this vertex.
  Index first_common_suspect(const Topology& topology, Index a, Index b) const {
    const std::uint32_t bits = common_suspects(topology, a, b);
    return bits == 0 ? kNone : topology.adjacency().vertices(a)[static_cast<std::size_t>(std::countr_zero(bits))];
  }

  std::size_t bytes() const;

 private:
  enum class Known : std::uint8_t { no, yes };

  void find_degenerate(const Step& step, const StarTable& stars, Executor& executor);
  void keep_known(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor);
  void forget_around(const Step& step, Index element);
  void classify(const Step& step, const StarTable& stars, Index v, StarTable::Ring& scratch);

  std::vector<std::int8_t> signs_;  ///< of volumes, by element slot
  /// By element slot. Sound: a tetrahedron out of D, each of whose faces has one other tetrahedron or nothing.
  std::vector<std::uint8_t> degenerate_, sound_;
  std::vector<std::uint8_t> suspect_, wound_;  ///< by vertex
  std::vector<std::uint8_t> suspect_places_;   ///< by element slot: bits of its vertices
  /// By vertex: its star goes once around it, and its ring once around; as long as neither folds.
  std::vector<Known> embedded_;
  BoundaryRings rings_;
  std::vector<std::uint8_t> folds_;
  std::vector<Vec3> last_,
      start_;   ///< where the vertices are at the end of the last step, and at the start of this one
  Motion gap_;  ///< from there to here
  std::vector<std::int8_t> gap_signs_;
  std::vector<Index> suspects_;
  std::vector<StarTable::Ring> scratch_;  ///< by worker
  std::size_t degenerate_count_ = 0;
};

}  // namespace volccd::detail
