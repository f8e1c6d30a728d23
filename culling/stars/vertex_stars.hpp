// Classifies the stars of vertices into those that remain embedded throughout a step and those that may fold.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/detail/boundary_rings.hpp>
#include <volccd/culling/stars/detail/cone_signs.hpp>
#include <volccd/culling/stars/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A star is clear if no two features of its elements that have no common vertex can touch, or come within the
/// separation, at any time of the step; a star of tetrahedra or triangles is then embedded at all times. All other
/// stars are suspect. The conditions, and the proof that they are sufficient, are in docs/clear_stars.md;
/// BoundaryFlood and StarOrphans both rely on it. All predicates are certified: a rounding error can only make a star
/// suspect.
///
/// Whether a star surrounds its vertex once (condition 4) can change only at times when one of its volumes is 0 or its
/// ring folds, or by a change of the topology. It remains known from step to step, or not proven, if neither occurs
/// throughout both steps and, if the next step does not begin at the positions where the last one ended, throughout the
/// straight motion between them.
///
/// Where the step has a Piece::cut_stars, a star that is not complete is classified as it is there, with all elements
/// of the mesh, and what is proven holds for its part in the topology as well. Not thread-safe; uses the executor.
class VertexStars {
 public:
  /// Classifies the stars of the step's topology. O(elements).
  void update(const Step& step, Executor& executor);

  /// Whether the star of v is not clear.
  bool suspect(Index v) const { return suspect_[v] != 0; }
  const std::vector<Index>& suspects() const { return suspects_; }  ///< suspect vertices, ascending

  /// 1 or -1 if the volume of a tetrahedron is proven to be positive or negative throughout the step, otherwise 0.
  int volume_sign(Index tetrahedron) const {
    return (signs_[tetrahedron].positive & 1) != 0 ? 1 : (signs_[tetrahedron].negative & 1) != 0 ? -1 : 0;
  }
  const StarTable& table() const { return table_; }

  std::size_t bytes() const {
    return heap_bytes(table_, rings_, judged_, folds_, suspect_, known_, all_positive_, signs_, gap_signs_, scratch_,
                      gap_, suspects_) +
           (cut_stars_ ? sizeof *cut_stars_ + cut_stars_->bytes() : 0);
  }

 private:
  /// Of condition 4. What is not proven at one time is not examined again where it cannot have changed.
  enum class Known : std::uint8_t { nothing, surrounded, not_proven };

  template <class IsJudged>
  bool set_judged(const Step& step, IsJudged&& is_judged);
  template <class IsJudged>
  void classify(const Step& step, Executor& executor, IsJudged&& is_judged);
  void find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const;
  void find_all_positive(const Step& step, Executor& executor);
  void invalidate_known(const Step& step, TopologyDelta::Extent changed, Executor& executor);
  bool find_gap(const Motion& motion, Executor& executor);
  int proven_sign(const Step& step, Index v) const;
  bool surrounds_once(const Step& step, Index v, int sign, RingSides& scratch) const;
  bool examine_star(const Step& step, Index v, RingSides& scratch);

  StarTable table_;
  BoundaryRings rings_;
  std::vector<std::uint8_t> judged_;           ///< by vertex: whether its star is classified here
  std::vector<std::uint8_t> folds_, suspect_;  ///< by vertex
  std::vector<Known> known_;                   ///< by vertex
  std::vector<std::uint8_t> all_positive_;     ///< by vertex: whether the volumes at it are all proven to be positive
  std::vector<ConeSigns> signs_, gap_signs_;   ///< by element slot
  std::vector<RingSides> scratch_;             ///< by worker
  Motion gap_;  ///< its start: where the last step ended; its end, if it was needed: the start of this one
  std::vector<Index> suspects_;
  bool complete_ = false;                   ///< whether the last update has ended
  std::unique_ptr<VertexStars> cut_stars_;  ///< of Piece::cut_stars, for the stars that are not complete; null without
};

}  // namespace volccd::detail
