// Classifies the stars of some vertices of one topology (docs/clear_stars.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/detail/boundary_rings.hpp>
#include <volccd/culling/stars/detail/cone_signs.hpp>
#include <volccd/culling/stars/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// What VertexStars knows of one topology. For each step, update() and then classify(). Not thread-safe; uses the
/// executor.
class StarClassifier {
 public:
  /// Updates the table for the topology. Returns how much of it has changed.
  TopologyDelta::Extent update(const Topology& topology, Executor& executor) {
    return table_.update(topology, executor);
  }
  /// Whose stars are classified from now on: vertices in use, ascending. To be called after update() wherever that
  /// found a change. Throws Error if there are too many boundary faces (BoundaryRings::set_faces).
  void set_judged(const Step& step, std::vector<Index> vertices);
  /// Classifies the stars. `gap`: the motion from the end of the last step to the start of this one, the same vertices;
  /// null if no vertex moves in it. O(elements).
  void classify(const Step& step, const Motion* gap, Executor& executor);

  const std::vector<Index>& judged() const { return judged_; }
  /// For a vertex whose star is classified: whether that is suspect.
  bool suspect(Index v) const { return suspect_[v] != 0; }
  const ConeSigns& signs(Index element) const { return signs_[element]; }
  const StarTable& table() const { return table_; }

  std::size_t bytes() const {
    return heap_bytes(table_, rings_, judged_, folds_, suspect_, known_, all_positive_, signs_, gap_signs_, scratch_);
  }

 private:
  /// Of condition 4. What is not proven at one time is not examined again where it cannot have changed.
  enum class Known : std::uint8_t { nothing, surrounded, not_proven };

  void find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const;
  void find_all_positive(const Step& step, Executor& executor);
  void invalidate_known(const Step& step, const Motion* gap, Executor& executor);
  int proven_sign(const Step& step, Index v) const;
  bool surrounds_once(const Step& step, Index v, int sign, RingSides& scratch) const;
  bool examine_star(const Step& step, Index v, RingSides& scratch);

  StarTable table_;
  BoundaryRings rings_;
  std::vector<Index> judged_;
  std::vector<std::uint8_t> folds_, suspect_;  ///< by vertex
  std::vector<Known> known_;                   ///< by vertex; nothing for those that are not judged
  std::vector<std::uint8_t> all_positive_;     ///< by vertex: whether the volumes at it are all proven to be positive
  std::vector<ConeSigns> signs_, gap_signs_;   ///< by element slot
  std::vector<RingSides> scratch_;             ///< by worker
};

}  // namespace volccd::detail
