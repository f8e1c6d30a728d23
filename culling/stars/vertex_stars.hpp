// Classifies the stars of vertices into those that remain embedded throughout a step and those that may fold.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/star_classifier.hpp>
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
    const ConeSigns& signs = own_.signs(tetrahedron);
    return (signs.positive & 1) != 0 ? 1 : (signs.negative & 1) != 0 ? -1 : 0;
  }
  const StarTable& table() const { return own_.table(); }

  std::size_t bytes() const {
    return heap_bytes(own_, gap_, suspect_, suspects_) + (cut_ ? sizeof *cut_ + cut_->bytes() : 0);
  }

 private:
  void sync(const Step& step, Executor& executor);
  const Motion* find_gap(const Motion& motion, Executor& executor);

  StarClassifier own_;                   ///< of the step's topology
  std::unique_ptr<StarClassifier> cut_;  ///< of Piece::cut_stars, for the stars that are not complete; null without
  Motion gap_;  ///< its start: where the last step ended; its end, if it was needed: the start of this one
  std::vector<std::uint8_t> suspect_;  ///< by vertex
  std::vector<Index> suspects_;
  bool complete_ = false;  ///< whether the last update has ended
};

}  // namespace volccd::detail
