// Static feature assignment: Section 5.2, Algorithm 4.
#pragma once

#include <volccd/query/roles/assignment.hpp>

namespace volccd {

/// Each feature belongs to its first incident element in ascending order of slots (the greedy choice of Algorithm 4). A
/// feature pair {a,b} is tested by the pair of the two elements to which a and b belong, which may be adjacent or
/// identical. On all element pairs, including adjacent ones and self pairs, this is complete, and each test is
/// performed exactly once.
///
/// Incomplete with an O-Set, as Section 5.2 explains: adjacent element pairs are then skipped, and a feature pair that
/// belongs to one of them, but is covered by other, non-adjacent elements, is not in the O-Set.
class StaticAssignment final : public Assignment {
 public:
  std::string incomplete_on_nonadjacent() const override;
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_static_assignment();

}  // namespace volccd
