// The orphan-source strategy: provides the tests of feature pairs that no pair of non-adjacent elements covers (the
// O-Set, Section 5.1).
#pragma once

#include <cstddef>

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// The blocks together contain every feature pair {a,b} without a common vertex that touches and for which all elements
/// of inc(a) are adjacent to all elements of inc(b). A pipeline with such a stage processes non-adjacent element pairs
/// only.
class OrphanSource : public Stage {
 public:
  static constexpr const char* kRole = "orphans";

  /// Number of blocks for the step of the last prepare().
  virtual std::size_t blocks(const StageState& state) const = 0;

  /// Appends the tests of one block, at most a few thousand. Called once per step for each block.
  virtual void run(const Step& step, StageState& state, unsigned worker, std::size_t block, TestBatch& out) const = 0;
};

}  // namespace volccd
