// The orphan-source strategy: provides the tests of feature pairs that no pair of non-adjacent elements covers (the
// O-Set, Section 5.1).
#pragma once

#include <volccd/query/work_source.hpp>

namespace volccd {

/// The blocks together contain every feature pair {a,b} without a common vertex that touches and for which all elements
/// of inc(a) are adjacent to all elements of inc(b). A pipeline with such a stage processes non-adjacent element pairs
/// only. A block contains at most a few thousand tests.
class OrphanSource : public WorkSource {
 public:
  static constexpr const char* kRole = "orphans";

  /// Number of blocks for the step of the last prepare().
  virtual std::size_t blocks(const StageState& state) const = 0;

  /// One round of tests.
  Round next_round(const Step&, StageState& state, std::size_t number, Executor&) const final {
    return {number == 0 ? blocks(state) : 0, RoundKind::tests};
  }
};

}  // namespace volccd
