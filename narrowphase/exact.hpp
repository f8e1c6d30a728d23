// The reference elementary test: exact arithmetic.
#pragma once

#include <volccd/narrowphase/narrow_phase.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// Reports exactly the tests whose features touch on the given doubles, as exact_first_touch() decides them
/// (exact_predicates.hpp); toi is the largest double that is not later than the exact first time. Normal, weights and
/// point are computed in doubles at toi. Degenerate tests (ExactAnswer::degenerate) are counted, nothing is undecided.
///
/// Two or three control points; no separation. Slow: microseconds to a millisecond a test, and it allocates.
class Exact final : public NarrowPhase {
 public:
  struct Config {};
  static const Options<Config>& options();

  Exact() = default;
  explicit Exact(Config) {}

  int max_control_points() const override { return 3; }
  /// Pre: separation 0 (asserted; a pipeline refuses other combinations).
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;
};

StageDescriptor<NarrowPhase> describe_exact();

}  // namespace volccd
