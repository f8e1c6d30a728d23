#include <algorithm>
#include <span>

#include <volccd/core/checked_executor.hpp>
#include <volccd/pipelines/detail/earliest_time.hpp>
#include <volccd/pipelines/detail/mark_kept.hpp>
#include <volccd/pipelines/detail/workspace_data.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

using detail::WorkerScratch;

/// A step has two sources of work, the broad phase and, if there is one, the orphan source; in the steps that a flood
/// takes, it is the only source. Each worker passes what a source hands out through the other stages itself. Counts are
/// kept per worker and added at the end, and contacts are sorted; both are independent of the number of workers.
class Pipeline::Run {
 public:
  Run(const Pipeline& pipeline, const Step& step, Workspace::Data& data, Executor& executor, const Request& request)
      : pipeline_(pipeline),
        step_(step),
        data_(data),
        executor_(executor),
        request_(request),
        test_stages_{.filters = pipeline.feature_filters_,
                     .narrow_phase = *pipeline.narrow_phase_,
                     .states = std::span(data.states).subspan(first_filter()),
                     .observer = request.observer,
                     .first_stage = first_filter(),
                     .given = request.tests != nullptr,
                     .collect = request.candidates != nullptr},
        earliest_(request.query, step.t_max, pipeline.narrow_phase_->time_tolerance()) {
    step_.range = pipeline.range_;
    step_.adjacency_table = nullptr;
    if (request.candidates) step_.piece.region = {};
  }

  void execute(StepResult& result, const Workspace& workspace) {
    double wall = 0;
    {
      StageClock clock;
      const StageTimer timer(clock, wall);
      prepare_workers();
      prepare_stages();
      if (request_.tests) {
        run_given_tests();
      } else if (flooded_) {
        run_source({*pipeline_.flood_, flood()});
      } else {
        run_source({*pipeline_.broad_phase_, kBroadPhase});
        if (pipeline_.orphans_) run_source({*pipeline_.orphans_, orphans()});
      }
      for_each_worker([&](unsigned w) { scratch(w).finish_tests(earliest_); });
      collect(result);
    }
    result.statistics.steps = 1;
    result.statistics.workspace_bytes = workspace.bytes();
    result.statistics.seconds = wall;
  }

 private:
  /// A source of work and its place among the stages.
  struct Source {
    const WorkSource& stage;
    std::size_t index;
  };

  /// Number of element pairs that are culled together, and number of tests that are given to the chain together: small
  /// enough for the caches, and large enough that the cost of clocks and virtual calls is negligible.
  static constexpr std::size_t kPairs = 256, kTests = 1024;
  /// Chunks of blocks for each worker: so many that workers share the work evenly, and that an executor can interrupt a
  /// long step in between.
  static constexpr std::size_t kChunks = 128;

  // ---- the loop

  /// Processes all work of a source: round by round, and in a round block by block, on all workers.
  void run_source(const Source& source) {
    for (std::size_t number = 0;; ++number) {
      const Round round = next_round(source, number);
      if (round.blocks == 0) return;
      const std::size_t grain = 1 + round.blocks / (kChunks * executor_.workers());
      executor_.parallel_for(round.blocks, grain, [&](std::size_t begin, std::size_t end, unsigned w) {
        const StageTimer timer(clock(w), statistics(w, source.index).seconds);
        for (std::size_t block = begin; block < end; ++block) {
          fetch(source, round, w, block);
          process_pairs(source, round, w, kPairs);
          run_tests(w);
        }
      });
      for_each_worker([&](unsigned w) { process_pairs(source, round, w, 1); });
    }
  }

  /// Performs the tests of the request.
  void run_given_tests() {
    executor_.parallel_for(request_.tests->size(), kTests, [&](std::size_t begin, std::size_t end, unsigned w) {
      scratch(w).work.tests.append(*request_.tests, begin, end);
      run_tests(w);
    });
  }

  Round next_round(const Source& source, std::size_t number) {
    const StageTimer timer(clock(0), statistics(0, source.index).seconds);
    return source.stage.next_round(step_, state(source.index), number, executor_);
  }

  /// Appends the work of a block to that of the worker.
  void fetch(const Source& source, const Round& round, unsigned w, std::size_t block) {
    WorkerScratch& worker = scratch(w);
    const std::size_t old_pairs = worker.work.pairs.size();
    const auto [old_vf, old_ee] = worker.work.tests.sizes();
    source.stage.run(step_.until(earliest_.limit()), state(source.index), w, block, worker.work);
    const auto pairs = std::span(worker.work.pairs).subspan(old_pairs);
    const std::size_t tests = worker.work.tests.size() - old_vf - old_ee;
    worker.sums.element_pairs += pairs.size();
    worker.sums.orphan_tests += tests;
    statistics(w, source.index).out += pairs.size() + (flooded_ ? 0 : tests);
    if (round.kind == RoundKind::tests) return observe_tests(source.index, w, old_vf, old_ee);
    const bool count_adjacent = request_.count_adjacent && step_.range == PairRange::every;
    if (!request_.observer && !count_adjacent) return;
    const StageTimer none(clock(w));
    if (request_.observer) request_.observer->observe(source.index, w, pair_step(), pairs, {});
    if (count_adjacent)
      for (const ElementPair pair : pairs)
        worker.sums.adjacent_pairs += step_.topology.adjacency().adjacent(pair.a, pair.b);
  }

  /// Processes the pairs of the worker in batches, if there are at least `min_count` of them. Tests are assigned only
  /// to pairs that were culled for the whole step: others could leave out features that touch.
  void process_pairs(const Source& source, const Round& round, unsigned w, std::size_t min_count) {
    WorkerScratch& worker = scratch(w);
    std::vector<ElementPair>& pairs = worker.work.pairs;
    while (pairs.size() >= min_count) {
      const std::size_t count = std::min(kPairs, pairs.size());
      worker.batch.assign(std::span(pairs).last(count));
      pairs.resize(pairs.size() - count);
      const bool at_start = round.kind == RoundKind::pairs_at_start;
      const Step step = pair_step().until(at_start ? 0 : earliest_.limit());
      cull_pairs(step, w);
      if (flooded_) record_survivors(source, w);
      if (at_start) continue;
      if (request_.initial_overlaps) worker.test_overlaps(step_);
      assign_tests(step, w);
      run_tests(w);
    }
  }

  void cull_pairs(const Step& step, unsigned w) {
    WorkerScratch& worker = scratch(w);
    for (std::size_t i = kFirstCulling; i < assignment() && worker.batch.size() != 0; ++i) {
      if (request_.observer) worker.observed = worker.batch.pairs;
      {
        const StageTimer timer(clock(w), statistics(w, i).seconds);
        statistics(w, i).in += worker.batch.size();
        pipeline_.element_culling_[i - kFirstCulling]->run(step, state(i), w, worker.batch);
        statistics(w, i).out += worker.batch.size();
      }
      if (request_.observer) observe_culling(i, step, w);
    }
  }

  void record_survivors(const Source& source, unsigned w) {
    const StageTimer timer(clock(w), statistics(w, source.index).seconds);
    const PairBatch& batch = scratch(w).batch;
    statistics(w, source.index).in += batch.size();
    source.stage.record_survivors(state(source.index), w, batch.pairs);
    source.stage.record_survivors(state(source.index), w, batch.contact_free);
  }

  void assign_tests(const Step& step, unsigned w) {
    WorkerScratch& worker = scratch(w);
    TestBatch& tests = worker.work.tests;
    const auto [old_vf, old_ee] = tests.sizes();
    {
      const StageTimer timer(clock(w), statistics(w, assignment()).seconds);
      pipeline_.assignment_->run(step, state(assignment()), w, worker.batch, tests);
      if (flooded_) pipeline_.flood_->to_mesh_features(state(flood()), tests, old_vf, old_ee);
    }
    observe_tests(assignment(), w, old_vf, old_ee);
    const std::size_t assigned = tests.size() - old_vf - old_ee;
    statistics(w, assignment()).in += worker.batch.size();
    statistics(w, assignment()).out += assigned;
    worker.sums.surviving_pairs += worker.batch.size();
    worker.sums.owned_tests += assigned;
  }

  void run_tests(unsigned w) {
    if (scratch(w).work.tests.size() >= kTests) scratch(w).run_tests(TestBlock::kCapacity, earliest_);
  }

  // ---- observers: they change nothing about what runs

  void observe_tests(std::size_t stage, unsigned w, std::size_t old_vf, std::size_t old_ee) {
    if (!request_.observer) return;
    const StageTimer none(clock(w));
    const TestBatch& tests = scratch(w).work.tests;
    request_.observer->observe(stage, w, step_, FeatureKind::vf, std::span(tests.vf).subspan(old_vf), {});
    request_.observer->observe(stage, w, step_, FeatureKind::ee, std::span(tests.ee).subspan(old_ee), {});
  }

  void observe_culling(std::size_t stage, const Step& step, unsigned w) {
    const StageTimer none(clock(w));
    WorkerScratch& worker = scratch(w);
    detail::mark_kept<ElementPair>(worker.observed, worker.batch.pairs, worker.observed_keep);
    request_.observer->observe(stage, w, step, worker.observed, worker.observed_keep);
  }

  // ---- before and after the loop

  void prepare_workers() {
    while (data_.workers.size() < executor_.workers()) data_.workers.push_back(std::make_unique<WorkerScratch>());
    for (unsigned w = 0; w < data_.workers.size(); ++w) {
      WorkerScratch& worker = scratch(w);
      worker.begin_step(pipeline_.spec_);
      worker.chain.start(step_, test_stages_,
                         std::span(worker.sums.stages).subspan(first_filter(), test_stages_.states.size()), w);
    }
  }

  /// Each stage that works in this step is prepared once, for the step that it then runs on.
  void prepare_stages() {
    if (pipeline_.flood_ && !request_.tests) {
      prepare_stage(flood(), step_);
      flooded_ = pipeline_.flood_->takes(state(flood()), request_.initial_overlaps);
    }
    for (std::size_t i = 0; i < pipeline_.stages_.size(); ++i)
      if (works(i) && pipeline_.stages_[i] != pipeline_.flood_.get())
        prepare_stage(i, i <= assignment() ? pair_step() : step_);
  }

  void prepare_stage(std::size_t stage, const Step& step) {
    StageClock clock;
    const StageTimer timer(clock, statistics(0, stage).prepare_seconds);
    pipeline_.stages_[stage]->prepare(step, state(stage), executor_);
    if (stage == first_filter() && !test_stages_.given && !pipeline_.feature_filters_.empty())
      pipeline_.feature_filters_[0]->prepare_select(step, state(stage), executor_);
  }

  /// Whether a stage works in this step: a flood replaces the other sources, given tests all stages that find tests.
  bool works(std::size_t stage) const {
    if (request_.tests) return stage >= first_filter();
    const Stage* const one = pipeline_.stages_[stage];
    if (one == pipeline_.flood_.get()) return flooded_;
    return !flooded_ || (one != pipeline_.broad_phase_.get() && one != pipeline_.orphans_.get());
  }

  void collect(StepResult& result) {
    for (std::size_t i = 0; i < pipeline_.stages_.size(); ++i)
      if (works(i)) pipeline_.stages_[i]->append_counters(state(i), statistics(0, i).counters);
    data_.merger.merge(data_.workers, executor_, result);
    if (request_.candidates) detail::ResultMerger::merge_collected(data_.workers, *request_.candidates);
    if (request_.query == Query::first) detail::keep_earliest(result.contacts);
    detail::complete(result, step_, request_.ends, executor_);
  }

  template <class Body>
  void for_each_worker(Body&& body) {
    executor_.parallel_for(data_.workers.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t w = begin; w < end; ++w) body(static_cast<unsigned>(w));
    });
  }

  WorkerScratch& scratch(unsigned w) const { return *data_.workers[w]; }
  StageClock& clock(unsigned w) const { return scratch(w).chain.clock(); }
  StageStatistics& statistics(unsigned w, std::size_t stage) const { return scratch(w).sums.stages[stage]; }
  StageState& state(std::size_t stage) const { return *data_.states[stage]; }
  /// The step of element culling and assignment.
  const Step& pair_step() const { return flooded_ ? pipeline_.flood_->step(state(flood())) : step_; }

  // Indices of the stages in Statistics::stages, in Workspace::Data::states and in Pipeline::stages_.
  static constexpr std::size_t kBroadPhase = 0, kFirstCulling = 1;
  std::size_t assignment() const { return kFirstCulling + pipeline_.element_culling_.size(); }
  std::size_t orphans() const { return assignment() + 1; }
  std::size_t flood() const { return assignment() + (pipeline_.orphans_ ? 2 : 1); }
  std::size_t first_filter() const { return flood() + (pipeline_.flood_ ? 1 : 0); }

  const Pipeline& pipeline_;
  Step step_;
  bool flooded_ = false;  ///< whether the flood takes the step
  Workspace::Data& data_;
  Executor& executor_;
  const Request& request_;
  const TestStages test_stages_;
  detail::EarliestTime earliest_;
};

void Pipeline::run(const Step& step, Workspace& workspace, Executor& executor, StepResult& result,
                   const Request& request) const {
  require_standard_floating_point();
  check(step, workspace);
  Workspace::Data& data = *workspace.data_;
  if (!data.intact) make_states(data);
  data.intact = false;
  CheckedExecutor checked(executor);
  Run(*this, step, data, checked, request).execute(result, workspace);
  data.intact = true;
}

}  // namespace volccd
