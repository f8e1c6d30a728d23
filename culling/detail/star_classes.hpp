// Classifies the parts of a simplicial complex that remain embedded throughout a step and those that may fold: the set
// D, clear stars and suspect stars.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/culling/detail/suspect_stars.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Classifies the elements and vertices of the complex for one step (docs/boundary_flood.md). All predicates are
/// certified: a rounding error can only add an element to D, or make a star suspect. With a separation they hold for
/// vertices that are displaced by up to half of it.
class StarClasses : public SuspectStars {
 public:
  /// `changed`: the return value of StarTable::update() for this topology.
  void update(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor);

  /// Whether the element is in D: a tetrahedron whose volume is not proven to keep its sign, or that has a face whose
  /// two tetrahedra are not proven to be on different sides of it.
  bool degenerate(Index o) const { return degenerate_[o] != 0; }
  std::size_t degenerate_count() const { return degenerate_count_; }
  /// Whether no element is in D or has a wound vertex.
  bool all_sound() const { return degenerate_count_ == 0 && wound_count_ == 0; }
  /// Whether a vertex of o is an interior vertex with a connected star outside of D that is not proven to surround the
  /// vertex exactly once.
  bool has_wound_vertex(const Topology& topology, Index o) const {
    if (wound_count_ == 0) return false;
    const std::span<const Index> vertices = topology.mesh().vertices(o);
    return std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return wound_[v] != 0; });
  }

  /// Bit i is set if the i-th vertex of simplex a is a vertex of b (Adjacency::vertices; a triangle repeats its first
  /// vertex).
  static std::uint32_t common_vertices(const Topology& topology, Index a, Index b) {
    const Index *x = topology.adjacency().vertices(a).data(), *y = topology.adjacency().vertices(b).data();
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i)
      bits |= std::uint32_t{x[i] == y[0] || x[i] == y[1] || x[i] == y[2] || x[i] == y[3]} << i;
    return bits;
  }
  /// The same bits, or 0 if a and b are proven to have no double points: one of the common vertices has a clear star,
  /// or a and b are tetrahedra outside of D that are identical or the only two tetrahedra at a common face.
  std::uint32_t common_suspects(const Topology& topology, Index a, Index b) const {
    const std::uint32_t common = common_vertices(topology, a, b);
    if ((common & ~std::uint32_t{suspect_places_[a]}) != 0) return 0;
    const std::uint32_t but_one = common & (common - 1);
    const bool three = (but_one & (but_one - 1)) != 0;
    return regular_[a] != 0 && regular_[b] != 0 && three ? 0 : common;
  }

  std::size_t bytes() const {
    return stars_bytes() + heap_bytes(signs_, gap_signs_, degenerate_, regular_, wound_, suspect_places_);
  }

 private:
  void find_signs(const Step& step, std::vector<std::int8_t>& signs, Executor& executor) const;
  void find_degenerate(const Step& step, const StarTable& stars, Executor& executor);
  StarTable::Fit fit_with_signs(const StarTable& stars, Index o) const;
  void classify(const Step& step, const StarTable& stars, Index v, Ring& scratch);

  std::vector<std::int8_t> signs_, gap_signs_;  ///< signs of volumes, by element slot
  /// By element slot. Regular: a tetrahedron outside of D of which each face has at most one other element, a
  /// tetrahedron.
  std::vector<std::uint8_t> degenerate_, regular_;
  std::vector<std::uint8_t> wound_;           ///< by vertex
  std::vector<std::uint8_t> suspect_places_;  ///< by element slot: bits of the element's suspect vertices
  std::size_t degenerate_count_ = 0, wound_count_ = 0;
};

}  // namespace volccd::detail
