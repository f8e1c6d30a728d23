// Classifies the stars of vertices, as sets of elements of any type, into those that remain embedded throughout a step
// and those that may fold.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/boundary_rings.hpp>
#include <volccd/culling/detail/cone_signs.hpp>
#include <volccd/culling/detail/element_star_table.hpp>
#include <volccd/culling/detail/step_gap.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A star is clear if no two features of its elements that have no common vertex can touch, or come within the
/// separation, at any time of the step. The conditions, and the proof that they are sufficient, are in
/// docs/star_orphans.md. All predicates are certified: a rounding error can only make a star suspect. Not thread-safe;
/// uses the executor.
class ElementStars {
 public:
  void update(const Step& step, Executor& executor);

  /// Whether the star of v is not clear.
  bool suspect(Index v) const { return suspect_[v] != 0; }
  const std::vector<Index>& suspects() const { return suspects_; }  ///< suspect vertices, ascending

  std::size_t bytes() const;

 private:
  enum class Known : std::uint8_t { no, yes };

  void find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const;
  void find_all_positive(const Step& step, Executor& executor);
  void keep_known(const Step& step, TopologyDelta::Extent changed, Executor& executor);
  bool is_clear(const Step& step, Index v, StarTable::Ring& scratch);

  ElementStarTable table_;
  std::vector<ConeSigns> signs_, gap_signs_;  ///< by element slot
  BoundaryRings rings_;
  std::vector<std::uint8_t> folds_, suspect_;  ///< by vertex
  std::vector<std::uint8_t> all_positive_;     ///< by vertex: whether common_sign() is 1
  /// By vertex: whether its cones and its ring surround it exactly once. Valid as long as no sign changes.
  std::vector<Known> once_;
  StepGap gap_;
  std::vector<Index> suspects_;
  std::vector<StarTable::Ring> scratch_;  ///< by worker
  bool complete_ = false;                 ///< whether the last update has ended
};

}  // namespace volccd::detail
