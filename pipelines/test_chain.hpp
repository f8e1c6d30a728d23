// How a worker processes tests: blocks of tests pass through the feature filters in order, then through the narrow
// phase.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include <volccd/pipelines/stage_clock.hpp>
#include <volccd/pipelines/stage_observer.hpp>
#include <volccd/pipelines/statistics.hpp>
#include <volccd/query/roles/feature_filter.hpp>
#include <volccd/query/roles/narrow_phase.hpp>
#include <volccd/query/work_source.hpp>

namespace volccd {

/// The stages of a chain with their states: those of the filters in order, then that of the narrow phase. The
/// referenced objects must outlive the run.
struct TestStages {
  std::span<const std::unique_ptr<FeatureFilter>> filters;
  const NarrowPhase& narrow_phase;
  std::span<const std::unique_ptr<StageState>> states;
  StageObserver* observer = nullptr;  ///< may be null
  std::size_t first_stage = 0;        ///< index of the first of these stages for the observer
  bool given = false;                 ///< the tests are those of a list: many are contacts that last
  bool collect = false;               ///< tests that the filters keep are collected in place of being performed
};

/// The tests of a worker are gathered once into blocks. The tests that a filter keeps are collected, separately for
/// each kind, in a block for the next stage, which runs when that block is full. Therefore blocks are full although
/// filters keep few tests.
///
/// Tests that the step does not ask for (Step::asks_for) are dropped: before the feature filters if the object filter
/// restricts the scope of pairs (inter or intra), otherwise after them. Without filters, the contacts of shell
/// neighbours are dropped in place of their tests.
///
/// Tests of a list do not pass through FeatureFilter::select(). With a separation, the narrow phase looks for contacts
/// that last (find_at_start) before the filters, unless one of these may leave tests to other ranks. Reused from step
/// to step; in steady state, it allocates memory for contacts only. Not thread-safe.
class TestChain {
 public:
  /// Begins a step and removes all tests and contacts. Results are added to `statistics`, which has as many entries as
  /// stages.states.
  void start(const Step& step, const TestStages& stages, std::span<StageStatistics> statistics, unsigned worker);

  /// From now on, filters may drop tests that touch only after t_max <= step.t_max. The narrow phase still receives the
  /// step unchanged.
  void prune(double t_max) { t_max_ = t_max; }

  /// Adds tests and runs the first stage on them; most efficient for multiples of TestBlock::kCapacity. Overwrites
  /// `tests`.
  void add(FeatureKind kind, std::span<FeaturePair> tests);
  /// Runs the later stages on the tests that remain in their blocks.
  void finish();

  /// With TestStages::collect: the tests that the filters kept, in no particular order.
  const TestBatch& collected() const { return collected_; }

  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }
  const NarrowCounters& counters() const { return counters_; }
  /// Number of tests of a kind that the narrow phase performed.
  std::uint64_t tests(FeatureKind kind) const { return tests_[static_cast<std::size_t>(kind)]; }
  StageClock& clock() { return clock_; }
  std::size_t bytes() const;

 private:
  using Blocks = std::deque<TestBlock>;  ///< block i: input of filter i; the last one: input of the narrow phase

  Blocks& blocks(FeatureKind kind) { return blocks_[static_cast<std::size_t>(kind)]; }
  bool drops_first() const;
  bool finds_at_start() const;
  void find_at_start();
  void name_features(const TestBlock& block, std::size_t first, std::span<std::uint8_t> found);
  std::span<FeaturePair> select(FeatureKind kind, std::span<FeaturePair> tests);
  void run(FeatureKind kind, std::size_t stage);
  void run_filter(FeatureKind kind, std::size_t stage);
  void collect(const TestBlock& block);
  void run_narrow_phase(const TestBlock& block);
  void drop_shell_neighbours(std::size_t first);
  void observe(std::size_t stage, const TestBlock& block, std::span<const std::uint8_t> keep);
  void observe_found(std::size_t first);
  void observe_dropped(FeatureKind kind, std::span<const FeaturePair> kept);

  const Step* step_ = nullptr;
  const TestStages* stages_ = nullptr;
  std::span<StageStatistics> statistics_;
  unsigned worker_ = 0;
  double t_max_ = 1;
  std::array<Blocks, 2> blocks_;
  TestBlock given_;  ///< for find_at_start()
  TestBatch collected_;
  std::vector<Contact> contacts_;
  NarrowCounters counters_;
  std::array<std::uint64_t, 2> tests_{};
  StageClock clock_;
  std::vector<FeaturePair> observed_;  ///< the tests before select(), for an observer
  std::vector<std::uint8_t> observed_keep_;
};

}  // namespace volccd
