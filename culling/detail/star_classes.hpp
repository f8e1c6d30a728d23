// Which parts of a simplicial complex stay embedded all through a step, and which may fold: D, clear and suspect stars.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Classifies the elements and vertices of the complex for one step (docs/boundary_flood.md). All predicates are certified:
/// rounding may only move an element into D, or make a star suspect. One thread at a time; uses the executor.
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

  std::size_t bytes() const;

 private:
  enum class Degree : std::uint8_t { unknown, one, other };

  void find_degenerate(const Step& step, const StarTable& stars, Executor& executor);
  void forget_degrees(const Step& step, const StarTable& stars, TopologyDelta::Extent changed);
  void classify(const Step& step, const StarTable& stars, Index v);

  std::vector<std::int8_t> signs_;         ///< of volumes, by element slot
  std::vector<std::uint8_t> degenerate_;   ///< by element slot
  std::vector<std::uint8_t> suspect_, wound_;  ///< by vertex
  std::vector<Degree> degrees_;            ///< by vertex; stays while no tetrahedron around is in D
  std::vector<Vec3> last_;                 ///< where the vertices were at the end of the last step
  std::vector<Index> suspects_;
  std::size_t degenerate_count_ = 0;
};

}  // namespace volccd::detail
