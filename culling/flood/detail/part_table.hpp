// A mesh whose elements are parts of the simplices of a complex.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/function_ref.hpp>
#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// For each simplex of a complex: no part, one of its faces, or the whole simplex. The parts are the elements of a
/// topology of their own, with the vertices of the complex, on which a broad phase can run. Changes become edits of
/// that topology. Not thread-safe during changes.
class PartTable {
 public:
  /// The vertices of a simplex that belong to its part, as bits, three of them for a face; none, or the whole simplex.
  using Kind = std::uint8_t;
  static constexpr Kind kNoPart = 0, kWhole = 0xff;
  using KindOf = FunctionRef<Kind(Index o)>;

  /// Replaces everything by the parts of all simplices of another complex. Simplices that are not live have none.
  void build(const Mesh& mesh, KindOf kind_of, Executor& executor);
  /// Replaces the parts of the simplices `slots`. Pre: since build(), all slots whose simplices changed were given.
  void update(const Mesh& mesh, std::span<const Index> slots, KindOf kind_of);

  /// Pre for all below: build() was called.
  const Topology& topology() const { return *parts_; }
  Index size() const { return parts_->mesh().element_count(); }
  /// Of a simplex, by its slot in the complex. One that is not the whole simplex leaves an inside.
  bool has_part(Index o) const { return kinds_[o] != kNoPart; }
  bool has_inside(Index o) const { return kinds_[o] != kWhole; }
  /// The vertices of the part of a simplex. Pre: has_part(o).
  std::span<const Index> part(Index o) const { return parts_->mesh().vertices(part_of_simplex_[o]); }
  /// Of the simplices of the parts: two parts without a common vertex may be those of adjacent simplices.
  const Adjacency& adjacency() const { return adjacency_; }
  /// The simplices of two parts (slots of topology()).
  ElementPair simplices(ElementPair parts) const {
    const Index a = simplex_of_part_[parts.a], b = simplex_of_part_[parts.b];
    return {std::min(a, b), std::max(a, b)};
  }

  std::size_t bytes() const;

 private:
  static ElementType type_of(const Mesh& mesh, Index o, Kind kind);
  static ElementSpec spec_of(const Mesh& mesh, Index o, Kind kind);
  void set_adjacent(const Mesh& mesh, std::span<const Index> removed, std::span<const Index> added);
  bool is_listed(const Mesh& mesh, Index o, Kind kind) const;

  std::optional<Topology> parts_;
  std::vector<Index> part_of_simplex_, simplex_of_part_;  ///< by slot; kNone without
  Adjacency adjacency_;                                   ///< by slot of topology(): the vertices of the simplex
  std::vector<Kind> kinds_;                               ///< by slot of the complex
};

}  // namespace volccd::detail
