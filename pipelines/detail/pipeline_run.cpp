#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>

#include <fmt/format.h>

#include <volccd/core/floating_point.hpp>
#include <volccd/pipelines/detail/workspace_data.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/shell_neighbours.hpp>

namespace volccd {

using detail::WorkerScratch;

namespace {

/// Wraps another executor whose threads must have the standard floating-point environment. The environment belongs to a
/// thread, hence it is checked once per chunk. parallel_for() throws ConfigError if a thread has a different one.
class CheckedExecutor final : public Executor {
 public:
  explicit CheckedExecutor(Executor& executor) : executor_(executor) {}

  unsigned workers() const override { return executor_.workers(); }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    executor_.parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
      require_standard_floating_point();
      body(begin, end, worker);
    });
  }

 private:
  Executor& executor_;
};

/// Wraps another executor and adds the time of its chunks to the statistics of one stage, separately for each worker.
/// Idle time is not included.
class ChargedExecutor final : public Executor {
 public:
  ChargedExecutor(Executor& executor, std::span<const std::unique_ptr<WorkerScratch>> workers, std::size_t stage)
      : executor_(executor), workers_(workers), stage_(stage) {}

  unsigned workers() const override { return executor_.workers(); }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    const StageTimer caller(caller_clock_, in_parallel_);
    if (workers() == 1) {
      const StageTimer timer(workers_[0]->chain.clock(), workers_[0]->sums.stages[stage_].seconds);
      return executor_.parallel_for(n, grain, body);
    }
    executor_.parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned w) {
      WorkerScratch& worker = *workers_[w];
      const StageTimer timer(worker.chain.clock(), worker.sums.stages[stage_].seconds);
      body(begin, end, w);
    });
  }

  /// Wall-clock time spent in parallel_for().
  double in_parallel() const { return in_parallel_; }

 private:
  Executor& executor_;
  std::span<const std::unique_ptr<WorkerScratch>> workers_;
  std::size_t stage_;
  StageClock caller_clock_;
  double in_parallel_ = 0;
};

}  // namespace

/// Tests have two sources: element pairs of the broad phase, after element culling and assignment, and blocks of
/// orphans. If a flood accepts the step, it proposes further pairs and provides the orphans. Each worker passes its
/// tests through the filters and the narrow phase itself, so that no list of all pairs or all tests is ever stored.
/// Counts are kept per worker and added at the end, and contacts are sorted into canonical order; both are independent
/// of the number of workers.
class Pipeline::Run {
 public:
  Run(const Pipeline& pipeline, const Step& step, Workspace::Data& data, Executor& executor, const Request& request)
      : pipeline_(pipeline),
        step_(step),
        data_(data),
        executor_(executor),
        request_(request),
        test_stages_{pipeline.feature_filters_, *pipeline.narrow_phase_, std::span(data.states).subspan(first_filter()),
                     request.observer, first_filter()},
        best_(std::min(step.t_max, 1.0)) {}

  void execute(StepResult& result, const Workspace& workspace) {
    double wall = 0;
    {
      StageClock clock;
      const StageTimer timer(clock, wall);
      prepare_workers();
      prepare_stages();
      run_broad_phase();
      if (flooded_) run_flood();
      if (pipeline_.orphans_) run_orphans();
      executor_.parallel_for(data_.workers.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t w = begin; w < end; ++w) finish_tests(*data_.workers[w]);
      });
      collect(result);
    }
    Statistics& statistics = result.statistics;
    statistics.steps = 1;
    statistics.workspace_bytes = workspace.bytes();
    statistics.seconds = wall;
  }

 private:
  /// Number of element pairs that are culled together, and number of tests that are given to the chain together: small
  /// enough for the caches, and large enough that the cost of clocks and virtual calls is negligible.
  static constexpr std::size_t kPairs = 256, kTests = 1024;
  /// The purpose for which pairs are culled: to assign their tests, or because the flood needs to know which of them
  /// touch at t = 0.
  enum class Purpose { tests, touch_at_start };

  void prepare_workers() {
    while (data_.workers.size() < executor_.workers()) data_.workers.push_back(std::make_unique<WorkerScratch>());
    for (unsigned w = 0; w < data_.workers.size(); ++w) {
      WorkerScratch& worker = *data_.workers[w];
      worker.tests.clear();
      worker.overlaps.clear();
      worker.left_out.clear();
      std::vector<StageStatistics> stages = std::move(worker.sums.stages);
      if (stages.empty()) {
        for (const auto& [role, choice] : pipeline_.spec_.stages()) stages.push_back({role, choice->name});
        stages.push_back({"initial-overlaps", "hulls"});
      }
      for (StageStatistics& stage : stages) stage = {std::move(stage.role), std::move(stage.name)};
      worker.sums = {};
      worker.sums.stages = std::move(stages);
      worker.chain.start(step_, test_stages_,
                         std::span(worker.sums.stages).subspan(first_filter(), test_stages_.states.size()), w);
    }
  }

  void prepare_stage(std::size_t stage, const Step& step) {
    StageClock clock;
    const StageTimer timer(clock, data_.workers[0]->sums.stages[stage].prepare_seconds);
    pipeline_.stages_[stage]->prepare(step, state(stage), executor_);
    if (stage == kBroadPhase)
      data_.workers[0]->sums.stages[stage].bounds_seconds += pipeline_.broad_phase_->bounds_seconds(state(stage));
  }

  void prepare_stages() {
    if (pipeline_.flood_) {
      prepare_stage(flood(), step_);
      flooded_ = pipeline_.flood_->takes(state(flood()), request_.initial_overlaps);
      if (flooded_) {
        outer_step_.emplace(pipeline_.flood_->step(state(flood())));
        complex_step_.emplace(*outer_step_).subset = nullptr;
      }
    }
    for (std::size_t i = 0; i < pipeline_.stages_.size(); ++i) {
      if (pipeline_.flood_ && i == flood()) continue;
      // The O-Set is not needed in this step; it is updated for the next step without a flood.
      if (flooded_ && i == orphans()) continue;
      prepare_stage(i, i == kBroadPhase ? broad_phase_step() : i <= assignment() ? pair_step() : step_);
    }
  }

  double charged_seconds() const {
    double sum = 0;
    for (const auto& worker : data_.workers)
      for (const StageStatistics& stage : worker->sums.stages) sum += stage.seconds;
    return sum;
  }

  /// Later stages run inside the broad phase. The broad phase is charged for its own part of each chunk and for its
  /// time outside of chunks; from the latter, the time that later stages spend there is subtracted.
  void run_broad_phase() {
    ChargedExecutor executor(executor_, data_.workers, kBroadPhase);
    StageClock clock;
    double all = 0, in_later_stages = 0;
    {
      const StageTimer timer(clock, all);
      pipeline_.broad_phase_->run(broad_phase_step(), state(kBroadPhase), pipeline_.range_, executor,
                                  [&](std::span<const ElementPair> pairs, unsigned w) {
                                    data_.workers[w]->sums.stages[kBroadPhase].out += pairs.size();
                                    observe_pairs(kBroadPhase, broad_phase_step(), pairs, w);
                                    const bool in_chunk = data_.workers[w]->chain.clock().running();
                                    const double before = in_chunk ? 0 : charged_seconds();
                                    take_pairs(pairs, w, Purpose::tests);
                                    if (!in_chunk) in_later_stages += charged_seconds() - before;
                                  });
    }
    data_.workers[0]->sums.stages[kBroadPhase].seconds += std::max(0.0, all - executor.in_parallel() - in_later_stages);
  }

  void run_flood() {
    const Flood& source = *pipeline_.flood_;
    StageStatistics& statistics = data_.workers[0]->sums.stages[flood()];
    StageClock clock;
    for (;;) {
      Flood::Front front;
      {
        const StageTimer timer(clock, statistics.seconds);
        front = source.next(state(flood()), executor_);
      }
      if (front.given_up) return begin_without_flood();
      if (front.pairs.empty()) return;
      statistics.out += front.pairs.size();
      executor_.parallel_for(front.pairs.size(), kPairs, [&](std::size_t begin, std::size_t end, unsigned w) {
        const Purpose purpose = front.at_start ? Purpose::touch_at_start : Purpose::tests;
        const auto pairs = front.pairs.subspan(begin, end - begin);
        observe_pairs(flood(), step_for(purpose), pairs, w);
        take_pairs(pairs, w, purpose);
      });
    }
  }

  /// Contacts that the flood has found are kept; contacts that are found again are merged with them.
  void begin_without_flood() {
    flooded_ = false;
    for (const auto& worker : data_.workers) worker->overlaps.clear();
    for (std::size_t i = 0; i <= orphans(); ++i) prepare_stage(i, step_);
    run_broad_phase();
  }

  /// Calls `append` of a stage, which appends tests to those of the worker, with the numbers of old VF and EE tests.
  /// Returns the number of new tests.
  template <class Append>
  std::size_t append_tests(std::size_t stage, unsigned w, Append&& append) {
    WorkerScratch& worker = *data_.workers[w];
    const TestBatch& tests = worker.tests;
    const std::size_t old_vf = tests.vf.size(), old_ee = tests.ee.size();
    {
      const StageTimer timer(worker.chain.clock(), worker.sums.stages[stage].seconds);
      append(old_vf, old_ee);
    }
    if (request_.observer) {
      request_.observer->observe(stage, w, step_, FeatureKind::vf, std::span(tests.vf).subspan(old_vf), {});
      request_.observer->observe(stage, w, step_, FeatureKind::ee, std::span(tests.ee).subspan(old_ee), {});
    }
    return tests.size() - old_vf - old_ee;
  }

  void run_orphans() {
    const std::size_t stage = flooded_ ? flood() : orphans();
    const std::size_t blocks =
        flooded_ ? pipeline_.flood_->orphan_blocks(state(stage)) : pipeline_.orphans_->blocks(state(stage));
    executor_.parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end, unsigned w) {
      WorkerScratch& worker = *data_.workers[w];
      Step step = step_;
      step.t_max = latest_time();
      for (std::size_t block = begin; block < end; ++block) {
        const std::size_t listed = append_tests(stage, w, [&](std::size_t, std::size_t) {
          if (flooded_)
            pipeline_.flood_->orphans(state(stage), block, worker.tests);
          else
            pipeline_.orphans_->run(step, state(stage), w, block, worker.tests);
        });
        if (!flooded_) worker.sums.stages[stage].out += listed;
        worker.sums.orphan_tests += listed;
        run_tests(worker, TestBlock::kCapacity);
      }
    });
  }

  /// With Query::first, pairs that touch only after the best contact so far are irrelevant. Since the narrow phase
  /// rounds its times, a slack is added, so that the answer does not depend on the order in which workers find
  /// contacts. The narrow phase itself always receives the original step.
  double latest_time() const {
    if (request_.query != Query::first) return step_.t_max;
    const double slack = 1e-12 + pipeline_.narrow_phase_->time_tolerance();
    return std::min(1.0, best_.load(std::memory_order_relaxed) * (1 + 1e-9) + slack);
  }

  const Step& broad_phase_step() const { return flooded_ ? *outer_step_ : step_; }
  const Step& pair_step() const { return flooded_ ? *complex_step_ : step_; }
  Step step_for(Purpose purpose) const {
    Step step = pair_step();
    step.t_max = purpose == Purpose::touch_at_start ? 0 : latest_time();
    return step;
  }

  /// Processes pairs from the broad phase or a flood. Tests are assigned only to pairs that were culled for the whole
  /// step: others could leave out features that touch.
  void take_pairs(std::span<const ElementPair> pairs, unsigned w, Purpose purpose) {
    WorkerScratch& worker = *data_.workers[w];
    const StageTimer nobody(worker.chain.clock());
    const Step step = step_for(purpose);
    worker.sums.element_pairs += pairs.size();
    if (request_.count_adjacent && pipeline_.range_ == PairRange::every)
      for (const ElementPair pair : pairs)
        worker.sums.adjacent_pairs += step.topology.adjacency().adjacent(pair.a, pair.b);
    for (std::size_t begin = 0; begin < pairs.size(); begin += kPairs) {
      worker.batch.assign(pairs.subspan(begin, std::min(kPairs, pairs.size() - begin)));
      cull_pairs(step, w);
      if (flooded_) {
        StageStatistics& statistics = worker.sums.stages[flood()];
        const StageTimer timer(worker.chain.clock(), statistics.seconds);
        statistics.in += worker.batch.size();
        pipeline_.flood_->reach(state(flood()), w, worker.batch.pairs);
        pipeline_.flood_->reach(state(flood()), w, worker.batch.contact_free);
      }
      if (purpose != Purpose::tests) continue;
      if (request_.initial_overlaps) {
        take_overlaps(worker.batch.pairs, worker);
        take_overlaps(worker.batch.contact_free, worker);
      }
      assign_tests(step, w);
      if (worker.tests.size() >= kTests) run_tests(worker, TestBlock::kCapacity);
    }
  }

  void assign_tests(const Step& step, unsigned w) {
    WorkerScratch& worker = *data_.workers[w];
    StageStatistics& statistics = worker.sums.stages[assignment()];
    const std::size_t tests = append_tests(assignment(), w, [&](std::size_t old_vf, std::size_t old_ee) {
      pipeline_.assignment_->run(step, state(assignment()), w, worker.batch, worker.tests);
      if (flooded_) pipeline_.flood_->to_mesh_features(state(flood()), worker.tests, old_vf, old_ee);
    });
    statistics.in += worker.batch.size();
    statistics.out += tests;
    worker.sums.surviving_pairs += worker.batch.size();
    worker.sums.owned_tests += tests;
  }

  void cull_pairs(const Step& step, unsigned w) {
    WorkerScratch& worker = *data_.workers[w];
    for (std::size_t i = 0; i < pipeline_.element_culling_.size() && worker.batch.size() != 0; ++i) {
      StageStatistics& statistics = worker.sums.stages[kFirstCulling + i];
      if (request_.observer) worker.observed = worker.batch.pairs;
      {
        const StageTimer timer(worker.chain.clock(), statistics.seconds);
        statistics.in += worker.batch.size();
        pipeline_.element_culling_[i]->run(step, state(kFirstCulling + i), w, worker.batch);
        statistics.out += worker.batch.size();
      }
      if (request_.observer) observe_culling(kFirstCulling + i, step, w);
    }
  }

  void observe_pairs(std::size_t stage, const Step& step, std::span<const ElementPair> pairs, unsigned w) const {
    if (!request_.observer) return;
    const StageTimer nobody(data_.workers[w]->chain.clock());
    request_.observer->observe(stage, w, step, pairs, {});
  }

  /// Element culling keeps the order of the pairs that it keeps.
  void observe_culling(std::size_t stage, const Step& step, unsigned w) const {
    WorkerScratch& worker = *data_.workers[w];
    worker.observed_keep.assign(worker.observed.size(), 0);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < worker.observed.size() && kept < worker.batch.size(); ++i)
      if (worker.observed[i] == worker.batch.pairs[kept]) {
        worker.observed_keep[i] = 1;
        ++kept;
      }
    request_.observer->observe(stage, w, step, worker.observed, worker.observed_keep);
  }

  void take_overlaps(std::span<const ElementPair> pairs, WorkerScratch& worker) {
    StageStatistics& statistics = worker.sums.stages[overlap_test()];
    const StageTimer timer(worker.chain.clock(), statistics.seconds);
    const Mesh& mesh = step_.mesh();
    const bool adjacency_known = pipeline_.range_ == PairRange::nonadjacent;
    std::vector<ElementPair>& candidates = worker.overlap_candidates;
    candidates.clear();
    for (const ElementPair pair : pairs)
      if ((adjacency_known || !step_.topology.adjacency().adjacent(pair.a, pair.b)) &&
          step_.filter.allows(mesh.object(pair.a), mesh.object(pair.b)))
        candidates.push_back(pair);
    const std::size_t before = worker.overlaps.size();
    worker.overlap_test.find(step_, candidates, worker.overlaps);
    statistics.in += candidates.size();
    statistics.out += worker.overlaps.size() - before;
  }

  /// Runs the largest number of tests of each kind that is a multiple of `multiple`; the others remain for the next
  /// call.
  void run_tests(WorkerScratch& worker, std::size_t multiple) {
    const std::size_t old_contacts = worker.chain.contacts().size();
    worker.chain.prune(latest_time());
    const auto run = [&](FeatureKind kind, std::vector<FeaturePair>& tests) {
      const std::size_t rest = tests.size() % multiple;
      worker.chain.add(kind, std::span(tests).subspan(rest));
      tests.resize(rest);
    };
    run(FeatureKind::vf, worker.tests.vf);
    run(FeatureKind::ee, worker.tests.ee);
    take_contacts(worker, old_contacts);
  }

  void finish_tests(WorkerScratch& worker) {
    run_tests(worker, 1);
    const std::size_t old_contacts = worker.chain.contacts().size();
    worker.chain.finish();
    take_contacts(worker, old_contacts);
  }

  /// Contacts from `old_contacts` on are new. A contact that is left out must not count as the first one.
  void take_contacts(WorkerScratch& worker, std::size_t old_contacts) {
    std::vector<Contact>& contacts = worker.chain.contacts();
    if (request_.leave_out_shell_neighbours) {
      const auto left_out = std::partition(contacts.begin() + static_cast<std::ptrdiff_t>(old_contacts), contacts.end(),
                                           [](const Contact& c) { return !share_shell_vertex(c.kind, c.vertices); });
      if (request_.query != Query::first) worker.left_out.insert(worker.left_out.end(), left_out, contacts.end());
      contacts.erase(left_out, contacts.end());
    }
    if (request_.query != Query::first) return;
    for (std::size_t i = old_contacts; i < contacts.size(); ++i) {
      const double toi = contacts[i].toi;
      double best = best_.load(std::memory_order_relaxed);
      while (toi < best && !best_.compare_exchange_weak(best, toi, std::memory_order_relaxed)) {
      }
    }
    const double best = best_.load(std::memory_order_relaxed);
    std::erase_if(contacts, [best](const Contact& contact) { return contact.toi > best; });
  }

  void collect(StepResult& result) {
    result.statistics = {};
    std::vector<std::span<const Contact>>&contacts_of = data_.contacts_of, &left_out_of = data_.left_out_of;
    contacts_of.clear();
    left_out_of.clear();
    for (const auto& worker : data_.workers) {
      TestChain& chain = worker->chain;
      worker->sums.vf_tests = chain.tests(FeatureKind::vf);
      worker->sums.ee_tests = chain.tests(FeatureKind::ee);
      worker->sums.degenerate = chain.counters().degenerate;
      worker->sums.undecided = chain.counters().undecided;
      result.statistics += worker->sums;
      contacts_of.push_back(chain.contacts());
      left_out_of.push_back(worker->left_out);
    }
    std::vector<Contact>& contacts = result.contacts;
    result.statistics.duplicates = data_.order.collect(contacts_of, executor_, contacts);
    result.statistics.duplicates += data_.order.collect(left_out_of, executor_, result.left_out);
    if (request_.query == Query::first && !contacts.empty()) {
      const auto earliest = std::min_element(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
        return x.toi != y.toi ? x.toi < y.toi : canonical_less(x, y);
      });
      contacts = {*earliest};
    }
    for (const Contact& contact : contacts) {
      result.statistics.earliest_toi = std::min(result.statistics.earliest_toi, contact.toi);
      result.statistics.contacts_at_start += contact.at_start ? 1 : 0;
    }
    result.statistics.contacts = contacts.size();
    result.statistics.left_out = result.left_out.size();
    std::vector<ElementPair>& overlaps = result.initial_overlaps;
    overlaps.clear();
    for (const auto& worker : data_.workers)
      overlaps.insert(overlaps.end(), worker->overlaps.begin(), worker->overlaps.end());
    std::sort(overlaps.begin(), overlaps.end());
    result.statistics.initial_overlaps = overlaps.size();
  }

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

  const Pipeline& pipeline_;
  const Step& step_;
  /// If a flood accepts the step: the step of its complex, with the outer parts for the broad phase alone, and without
  /// for culling and assignment.
  std::optional<Step> outer_step_, complex_step_;
  bool flooded_ = false;
  Workspace::Data& data_;
  Executor& executor_;
  const Request& request_;
  const TestStages test_stages_;
  std::atomic<double> best_;  ///< time of the earliest contact so far (Query::first)
};

void Pipeline::run(const Step& step, Workspace& workspace, Executor& executor, StepResult& result,
                   const Request& request) const {
  require_standard_floating_point();
  if (!workspace.data_ || workspace.data_->pipeline != id_)
    throw ConfigError(
        fmt::format("pipeline {}: the workspace is not one of this pipeline; make it with make_workspace() of the "
                    "pipeline that runs",
                    spec_.name));
  check(step);
  if (request.leave_out_shell_neighbours && step.mesh().vertex_count() % 3 != 0)
    throw ConfigError(
        fmt::format("shell neighbours can be left out of thickened shells only: the mesh has {} vertices, "
                    "not three for each vertex of a shell mesh",
                    step.mesh().vertex_count()));
  Workspace::Data& data = *workspace.data_;
  if (!data.intact) make_states(data);
  data.intact = false;
  CheckedExecutor checked(executor);
  Run(*this, step, data, checked, request).execute(result, workspace);
  data.intact = true;
}

}  // namespace volccd
