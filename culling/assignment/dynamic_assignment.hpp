// Dynamic feature assignment: Section 5.2, Algorithm 5.
#pragma once

#include <volccd/query/roles/assignment.hpp>

namespace volccd {

/// The owner of a feature pair {a,b} is the first pair of non-adjacent elements in inc(a) x inc(b), with elements in
/// ascending order of slots. The edges of an EE pair are first put in the order of their slots; otherwise the pair
/// could have no owner or two owners. Only its owner tests a feature pair. Pairs without an owner form the O-Set
/// (Section 5.1), which `o-set` lists. Together they contain every test exactly once (the literal O-Set repeats some),
/// and adjacent element pairs need not be processed.
///
/// The time for an element pair is proportional to its number of features and owned tests, not to its number of feature
/// pairs, unless neighbours of one element are adjacent to neighbours of the other.
class DynamicAssignment final : public Assignment {
 public:
  std::string incomplete_on_every() const override;
  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  /// Pairs of adjacent elements in the batch own no feature pairs and contribute no tests.
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_dynamic_assignment();

}  // namespace volccd
