// Dynamic feature assignment: Section 5.2, Algorithm 5.
#pragma once

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// The owner of a feature pair {a,b} is the first pair of non-adjacent elements in inc(a) x inc(b), elements by
/// ascending slot; an EE pair is put in the order of its edge slots first, or it would have no owner or two. A feature
/// pair is tested by its owner alone; those without one are the O-Set (Section 5.1), which `o-set` lists. Together they
/// give every test exactly once (the literal O-Set repeats some), and adjacent element pairs need not be looked at.
///
/// The time for an element pair is proportional to its features and the tests that it owns, not to its feature pairs,
/// except where elements around one are adjacent to elements around the other.
class DynamicAssignment final : public Assignment {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit DynamicAssignment(const Config&) {}

  std::string incomplete_on_every() const override;
  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  /// Pairs of adjacent elements in the batch own nothing and give no tests.
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_dynamic_assignment();

}  // namespace volccd
