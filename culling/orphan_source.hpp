// The orphan strategy: tests of feature pairs that no pair of non-adjacent elements covers (the O-Set, Section 5.1).
#pragma once

#include <cstddef>

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// The blocks together contain every feature pair {a,b} without a common vertex for which all elements of inc(a) are
/// adjacent to all of inc(b), as long as its features touch. A pipeline with such a stage looks at non-adjacent element
/// pairs only.
class OrphanSource : public Stage {
 public:
  static constexpr const char* kRole = "orphans";

  /// How many blocks there are for the step that prepare() was called with last.
  virtual std::size_t blocks(const StageState& state) const = 0;

  /// Appends the tests of one block, at most a few thousand. Each block is asked for once a step.
  virtual void run(const Step& step, StageState& state, unsigned worker, std::size_t block, TestBatch& out) const = 0;
};

}  // namespace volccd
