// Static feature assignment: Section 5.2, Algorithm 4.
#pragma once

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// Each feature belongs to the first element that has it, in the order of slots (Algorithm 4's greedy choice). A
/// feature pair {a,b} is tested by the pair of elements that they belong to, which may be adjacent, or one element:
/// complete, and each test exactly once, on all pairs, adjacent ones and self pairs included.
///
/// Incomplete with an O-Set, as Section 5.2 says: then adjacent pairs are skipped, and pairs that belong to them but
/// are covered by other, non-adjacent elements are in no O-Set.
class StaticAssignment final : public Assignment {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit StaticAssignment(const Config&) {}

  std::string incomplete_on_nonadjacent() const override;
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_static_assignment();

}  // namespace volccd
