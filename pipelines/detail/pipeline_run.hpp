// One run of a pipeline on one step.
#pragma once

#include <atomic>
#include <span>

#include <volccd/pipelines/detail/workspace_data.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// Batches of the broad phase flow through all later stages on the worker that received them, so that no list of all pairs
/// or all tests exists at any time. Sums are kept by worker and added in the end; contacts are put in canonical order: both
/// are independent of the number of workers.
class Pipeline::Run {
 public:
  Run(const Pipeline& pipeline, const Step& step, Workspace::Data& data, Executor& executor,
      const Request& request);

  void execute(StepResult& result, const Workspace& workspace);

 private:
  /// Element pairs that go through culling at once, tests that go through filters at once: small enough for the caches,
  /// large enough that clocks and virtual calls do not count.
  static constexpr std::size_t kPairs = 256, kTests = 1024;

  void prepare_workers();
  double stage_seconds() const;
  void update_stages();
  void count_adjacent(std::span<const ElementPair> pairs, Statistics& sums) const;
  void take_pairs(std::span<const ElementPair> pairs, detail::WorkerScratch& worker);
  void take_overlaps(const PairBatch& batch, detail::WorkerScratch& worker);
  void take_orphans(std::size_t block, detail::WorkerScratch& worker);
  void run_tests(detail::WorkerScratch& worker);
  void run_group(FeatureKind kind, std::span<FeaturePair> tests, detail::WorkerScratch& worker);
  std::size_t filter_objects(FeatureKind kind, std::span<FeaturePair> tests) const;
  std::size_t apply_filter(std::size_t filter, const Step& step, FeatureKind kind, std::span<FeaturePair> tests,
                           detail::WorkerScratch& worker) const;
  void note_first(detail::WorkerScratch& worker, std::size_t old_contacts);
  void collect(StepResult& result);
  void collect_overlaps(StepResult& result) const;
  Step pruned_step() const;

  // Places of the stages in Statistics::stages.
  std::size_t culling_stage(std::size_t i) const { return 2 + i; }
  std::size_t feature_stage() const { return 2 + pipeline_.element_culling_.size(); }
  std::size_t orphan_stage() const { return feature_stage() + 1; }
  std::size_t filter_stage(std::size_t i) const { return orphan_stage() + 1 + i; }
  std::size_t narrow_stage() const { return filter_stage(pipeline_.feature_filters_.size()); }
  std::size_t overlap_stage() const { return narrow_stage() + 1; }
  std::vector<StageStatistics> empty_stages() const;

  const Pipeline& pipeline_;
  const Step& step_;
  Workspace::Data& data_;
  Executor& executor_;
  const Query query_;
  const bool overlaps_asked_;
  /// Number of element-culling stages that run before the test of initial overlaps: all that a pair which overlaps passes.
  const std::size_t overlaps_after_;
  const PairRange range_;
  std::atomic<double> best_;  ///< earliest contact so far (Query::first)
};

}  // namespace volccd
