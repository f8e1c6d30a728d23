// The reference elementary test: exact arithmetic.
#pragma once

#include <volccd/query/contact.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd {

/// Reports exactly the tests whose features touch, or come within the separation, for the given doubles, as
/// exact_first_touch() decides (exact_predicates.hpp). toi is the largest double that is not later than the exact first
/// time. Normal, weights and point are computed in doubles at toi. Degenerate tests (ExactAnswer::degenerate) are
/// counted; no test is undecided.
///
/// Two or three control points, any separation. A test takes microseconds to a millisecond and allocates memory.
class Exact final : public NarrowPhase {
 public:
  int max_control_points() const override { return 3; }
  bool handles_separation() const override { return true; }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;
};

StageDescriptor<NarrowPhase> describe_exact();

}  // namespace volccd
