// A run of a pipeline on one step.
#pragma once

#include <atomic>
#include <optional>
#include <span>

#include <volccd/pipelines/detail/workspace_data.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// Tests have two sources: element pairs of the broad phase, after element culling and assignment, and blocks of
/// orphans. If a flood accepts the step, it proposes further pairs and provides the orphans. Each worker passes its
/// tests through the filters and the narrow phase itself, so that no list of all pairs or all tests is ever stored.
/// Counts are kept per worker and added at the end, and contacts are sorted into canonical order; both are independent
/// of the number of workers.
class Pipeline::Run {
 public:
  Run(const Pipeline& pipeline, const Step& step, Workspace::Data& data, Executor& executor, const Request& request);

  void execute(StepResult& result, const Workspace& workspace);

 private:
  /// Number of element pairs that are culled together, and number of tests that are given to the chain together: small
  /// enough for the caches, and large enough that the cost of clocks and virtual calls is negligible.
  static constexpr std::size_t kPairs = 256, kTests = 1024;

  void prepare_workers();
  void prepare_stages();
  void run_broad_phase();
  void prepare_stage(std::size_t stage, const Step& step);
  void run_flood();
  void begin_without_flood();
  void run_orphans();
  double charged_seconds() const;
  const Step& pair_step() const { return flooded_ ? *flood_step_ : step_; }
  double latest_time() const;
  void count_adjacent(std::span<const ElementPair> pairs, Statistics& sums) const;
  /// The purpose for which pairs are culled: to assign their tests, as seeds of the flood, or because the flood needs
  /// to know which of them touch at t = 0.
  enum class Purpose { tests, seeds, touch_at_start };
  Step step_for(Purpose purpose) const;
  void take_pairs(std::span<const ElementPair> pairs, unsigned w, Purpose purpose);
  void assign_tests(const Step& step, unsigned w);
  void cull_pairs(const Step& step, unsigned w);
  void observe_pairs(std::size_t stage, const Step& step, std::span<const ElementPair> pairs, unsigned w) const;
  void observe_culling(std::size_t stage, const Step& step, unsigned w) const;
  void observe_tests(std::size_t stage, unsigned w, std::size_t old_vf, std::size_t old_ee) const;
  void take_overlaps(std::span<const ElementPair> pairs, detail::WorkerScratch& worker);
  void run_tests(detail::WorkerScratch& worker, std::size_t multiple);
  void finish_tests(detail::WorkerScratch& worker);
  void take_contacts(detail::WorkerScratch& worker, std::size_t old_contacts);
  void leave_out(detail::WorkerScratch& worker, std::size_t old_contacts) const;
  void note_first(detail::WorkerScratch& worker, std::size_t old_contacts);
  void collect(StepResult& result);
  void collect_overlaps(StepResult& result) const;

  // Indices of the stages in Statistics::stages, in Workspace::Data::states and in Pipeline::stages_.
  static constexpr std::size_t kBroadPhase = 0, kFirstCulling = 1;
  std::size_t assignment() const { return kFirstCulling + pipeline_.element_culling_.size(); }
  std::size_t orphans() const { return assignment() + 1; }
  std::size_t flood() const { return assignment() + (pipeline_.orphans_ ? 2 : 1); }
  std::size_t first_filter() const { return flood() + (pipeline_.flood_ ? 1 : 0); }
  std::size_t overlap_test() const { return pipeline_.stages_.size(); }
  StageState& state(std::size_t stage) const {
    return flooded_ && stage == kBroadPhase ? *data_.flood_broad_phase : *data_.states[stage];
  }
  std::vector<StageStatistics> empty_stages() const;

  const Pipeline& pipeline_;
  const Step& step_;
  std::optional<Step> flood_step_;  ///< step for broad phase, culling and assignment if a flood accepts the step
  bool flooded_ = false;
  Workspace::Data& data_;
  Executor& executor_;
  const Query query_;
  const bool overlaps_requested_, adjacent_requested_, shell_neighbours_left_out_;
  StageObserver* const observer_;  ///< may be null
  const TestStages test_stages_;
  std::atomic<double> best_;  ///< time of the earliest contact so far (Query::first)
};

}  // namespace volccd
