#include <volccd/pipelines/detail/pipeline_run.hpp>

#include <algorithm>
#include <cmath>

namespace volccd {

using detail::StopWatch;
using detail::WorkerScratch;

namespace {

/// Leading stages that drop only pairs whose elements are disjoint.
std::size_t disjoint_droppers(const std::vector<std::unique_ptr<ElementCulling>>& stages) {
  const auto other = std::find_if(stages.begin(), stages.end(), [](const auto& s) { return !s->drops_only_disjoint(); });
  return static_cast<std::size_t>(other - stages.begin());
}

}  // namespace

Pipeline::Run::Run(const Pipeline& pipeline, const Step& step, Workspace::Data& data, Executor& executor,
                   const Request& request)
    : pipeline_(pipeline),
      step_(step),
      data_(data),
      executor_(executor),
      query_(request.query),
      overlaps_asked_(request.initial_overlaps),
      overlaps_after_(disjoint_droppers(pipeline.element_culling_)),
      range_(pipeline.feature_culling_->needs_adjacent_pairs() ? PairRange::every : PairRange::nonadjacent),
      best_(std::min(step.t_max, 1.0)) {}

std::vector<StageStatistics> Pipeline::Run::empty_stages() const {
  const PipelineSpec& spec = pipeline_.spec_;
  std::vector<StageStatistics> stages;
  stages.push_back({"update", spec.broad_phase.name});
  stages.push_back({"broad-phase", spec.broad_phase.name});
  for (const StageChoice& choice : spec.element_culling) stages.push_back({"element-culling", choice.name});
  stages.push_back({"feature-culling", spec.feature_culling.name});
  stages.push_back({"orphans", spec.feature_culling.name});
  for (const StageChoice& choice : spec.feature_filters) stages.push_back({"feature-filter", choice.name});
  stages.push_back({"narrow-phase", spec.narrow_phase.name});
  stages.push_back({"initial-overlaps", "hulls"});
  return stages;
}

void Pipeline::Run::execute(StepResult& result, const Workspace& workspace) {
  StopWatch whole;
  prepare_workers();
  update_stages();

  // Later stages run inside the traversal: what they take is told apart from the traversal itself.
  const double before = stage_seconds();
  StopWatch watch;
  pipeline_.broad_phase_->query(step_, *data_.broad_phase, range_, executor_,
                                [&](std::span<const ElementPair> pairs, unsigned w) {
                                  take_pairs(pairs, *data_.workers[w]);
                                });
  const double traversal = watch.lap() * executor_.workers() - (stage_seconds() - before);
  data_.workers[0]->sums.stages[1].seconds += std::max(0.0, traversal);

  executor_.parallel_for(pipeline_.feature_culling_->orphan_blocks(*data_.feature_culling), 1,
                         [&](std::size_t begin, std::size_t end, unsigned w) {
                           for (std::size_t b = begin; b < end; ++b) take_orphans(b, *data_.workers[w]);
                         });
  executor_.parallel_for(data_.workers.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t w = begin; w < end; ++w) run_tests(*data_.workers[w]);
  });
  collect(result);

  Statistics& statistics = result.statistics;
  statistics.steps = 1;
  statistics.workspace_bytes = workspace.bytes();
  statistics.seconds = whole.lap();
}

void Pipeline::Run::prepare_workers() {
  while (data_.workers.size() < executor_.workers()) data_.workers.push_back(std::make_unique<WorkerScratch>());
  for (const auto& worker : data_.workers) {
    worker->tests.clear();
    worker->contacts.clear();
    worker->overlaps.clear();
    worker->narrow = {};
    std::vector<StageStatistics> stages = std::move(worker->sums.stages);
    if (stages.empty()) stages = empty_stages();
    for (StageStatistics& stage : stages) stage.in = stage.out = 0, stage.seconds = 0;
    worker->sums = {};
    worker->sums.stages = std::move(stages);
  }
}

double Pipeline::Run::stage_seconds() const {
  double sum = 0;
  for (const auto& worker : data_.workers)
    for (const StageStatistics& stage : worker->sums.stages) sum += stage.seconds;
  return sum;
}

void Pipeline::Run::update_stages() {
  std::vector<StageStatistics>& stages = data_.workers[0]->sums.stages;
  StopWatch watch;
  pipeline_.broad_phase_->update(step_, *data_.broad_phase, executor_);
  stages[0].seconds += watch.lap();
  for (std::size_t i = 0; i < pipeline_.element_culling_.size(); ++i) {
    pipeline_.element_culling_[i]->update(step_, data_.element_culling[i].get());
    stages[culling_stage(i)].seconds += watch.lap();
  }
  pipeline_.feature_culling_->update(step_, *data_.feature_culling);
  stages[feature_stage()].seconds += watch.lap();
}

/// With Query::first, what touches only after the best contact so far does not matter. The slack keeps the answer
/// independent of the order in which workers find contacts although the narrow phase rounds its times; the narrow phase
/// itself always sees the step as it was given.
Step Pipeline::Run::pruned_step() const {
  Step step = step_;
  const double slack = 1e-12 + pipeline_.narrow_phase_->time_tolerance();
  if (query_ == Query::first) step.t_max = std::min(1.0, best_.load(std::memory_order_relaxed) * (1 + 1e-9) + slack);
  return step;
}

void Pipeline::Run::count_adjacent(std::span<const ElementPair> pairs, Statistics& sums) const {
  sums.element_pairs += pairs.size();
  if (range_ == PairRange::nonadjacent) return;
  for (const ElementPair pair : pairs) sums.adjacent_pairs += step_.topology.adjacency().adjacent(pair.a, pair.b);
}

void Pipeline::Run::take_pairs(std::span<const ElementPair> pairs, WorkerScratch& worker) {
  const Step step = pruned_step();
  Statistics& sums = worker.sums;
  count_adjacent(pairs, sums);
  sums.stages[1].out += pairs.size();
  for (std::size_t begin = 0; begin < pairs.size(); begin += kPairs) {
    const auto part = pairs.subspan(begin, std::min(kPairs, pairs.size() - begin));
    PairBatch& batch = worker.batch;
    batch.pairs.assign(part.begin(), part.end());
    batch.masks.assign(part.size(), FeatureMask{});
    StopWatch watch;
    if (overlaps_after_ == 0) take_overlaps(batch, worker);
    watch.lap();
    for (std::size_t i = 0; i < pipeline_.element_culling_.size() && batch.size() != 0; ++i) {
      StageStatistics& stage = sums.stages[culling_stage(i)];
      stage.in += batch.size();
      pipeline_.element_culling_[i]->cull(step, data_.element_culling[i].get(), batch);
      stage.out += batch.size();
      stage.seconds += watch.lap();
      if (i + 1 != overlaps_after_) continue;
      take_overlaps(batch, worker);
      watch.lap();
    }
    sums.surviving_pairs += batch.size();
    const std::size_t before = worker.tests.vf.size() + worker.tests.ee.size();
    pipeline_.feature_culling_->tests(step, *data_.feature_culling, batch, worker.tests);
    const std::size_t owned = worker.tests.vf.size() + worker.tests.ee.size() - before;
    StageStatistics& stage = sums.stages[feature_stage()];
    stage.in += batch.size();
    stage.out += owned;
    stage.seconds += watch.lap();
    sums.owned_tests += owned;
    if (before + owned >= kTests) run_tests(worker);
  }
}

void Pipeline::Run::take_overlaps(const PairBatch& batch, WorkerScratch& worker) {
  if (!overlaps_asked_) return;
  StopWatch watch;
  const Mesh& mesh = step_.mesh();
  const bool adjacency_known = range_ == PairRange::nonadjacent;
  std::vector<ElementPair>& candidates = worker.overlap_candidates;
  candidates.clear();
  for (const ElementPair pair : batch.pairs)
    if ((adjacency_known || !step_.topology.adjacency().adjacent(pair.a, pair.b)) &&
        step_.filter.allows(mesh.object(pair.a), mesh.object(pair.b)))
      candidates.push_back(pair);
  const std::size_t before = worker.overlaps.size();
  worker.overlap_test.find(step_, candidates, worker.overlaps);
  StageStatistics& stage = worker.sums.stages[overlap_stage()];
  stage.in += candidates.size();
  stage.out += worker.overlaps.size() - before;
  stage.seconds += watch.lap();
}

void Pipeline::Run::take_orphans(std::size_t block, WorkerScratch& worker) {
  StopWatch watch;
  const std::size_t before = worker.tests.vf.size() + worker.tests.ee.size();
  pipeline_.feature_culling_->orphans(step_, *data_.feature_culling, block, worker.tests);
  const std::size_t orphans = worker.tests.vf.size() + worker.tests.ee.size() - before;
  StageStatistics& stage = worker.sums.stages[orphan_stage()];
  stage.out += orphans;
  stage.seconds += watch.lap();
  worker.sums.orphan_tests += orphans;
  if (before + orphans >= kTests) run_tests(worker);
}

void Pipeline::Run::run_tests(WorkerScratch& worker) {
  const auto run_all = [&](FeatureKind kind, std::vector<FeaturePair>& tests) {
    for (std::size_t begin = 0; begin < tests.size(); begin += kTests)
      run_group(kind, std::span(tests).subspan(begin, std::min(kTests, tests.size() - begin)), worker);
    tests.clear();
  };
  run_all(FeatureKind::vf, worker.tests.vf);
  run_all(FeatureKind::ee, worker.tests.ee);
}

void Pipeline::Run::run_group(FeatureKind kind, std::span<FeaturePair> tests, WorkerScratch& worker) {
  StopWatch watch;
  const Step step = pruned_step();
  // Where only some objects are excluded, most tests are asked for: then less is looked up after the filters.
  const bool scope = step.filter.scope() != PairScope::all;
  if (scope) tests = tests.first(filter_objects(kind, tests));
  for (std::size_t i = 0; i < pipeline_.feature_filters_.size() && !tests.empty(); ++i) {
    StageStatistics& stage = worker.sums.stages[filter_stage(i)];
    stage.in += tests.size();
    tests = tests.first(apply_filter(i, step, kind, tests, worker));
    stage.out += tests.size();
    stage.seconds += watch.lap();
  }
  if (!scope && !step.filter.trivial()) tests = tests.first(filter_objects(kind, tests));
  StageStatistics& stage = worker.sums.stages[narrow_stage()];
  stage.in += tests.size();
  (kind == FeatureKind::vf ? worker.sums.vf_tests : worker.sums.ee_tests) += tests.size();
  const std::size_t before = worker.contacts.size();
  pipeline_.narrow_phase_->test(step_, kind, tests, worker.contacts, worker.narrow);
  stage.out += worker.contacts.size() - before;
  stage.seconds += watch.lap();
  if (query_ == Query::first) note_first(worker, before);
}

std::size_t Pipeline::Run::filter_objects(FeatureKind kind, std::span<FeaturePair> tests) const {
  const auto unwanted = [&](FeaturePair pair) { return !step_.filter.asks_for(step_.topology, kind, pair); };
  return static_cast<std::size_t>(std::remove_if(tests.begin(), tests.end(), unwanted) - tests.begin());
}

std::size_t Pipeline::Run::apply_filter(std::size_t filter, const Step& step, FeatureKind kind,
                                        std::span<FeaturePair> tests, WorkerScratch& worker) const {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < tests.size(); begin += TestBlock::kCapacity) {
    const auto part = tests.subspan(begin, std::min(TestBlock::kCapacity, tests.size() - begin));
    worker.block.gather(step, kind, part);
    worker.keep.assign(worker.block.padded_size(), 1);
    pipeline_.feature_filters_[filter]->filter(step, worker.block, worker.keep);
    for (std::size_t i = 0; i < part.size(); ++i) {
      tests[kept] = part[i];
      kept += worker.keep[i] != 0 ? 1 : 0;
    }
  }
  return kept;
}

void Pipeline::Run::note_first(WorkerScratch& worker, std::size_t old_contacts) {
  for (std::size_t i = old_contacts; i < worker.contacts.size(); ++i) {
    const double toi = worker.contacts[i].toi;
    double best = best_.load(std::memory_order_relaxed);
    while (toi < best && !best_.compare_exchange_weak(best, toi, std::memory_order_relaxed)) {
    }
  }
  const double best = best_.load(std::memory_order_relaxed);
  std::erase_if(worker.contacts, [best](const Contact& contact) { return contact.toi > best; });
}

void Pipeline::Run::collect(StepResult& result) {
  result.contacts.clear();
  result.statistics = {};
  for (const auto& worker : data_.workers) {
    worker->sums.degenerate = worker->narrow.degenerate;
    worker->sums.undecided = worker->narrow.undecided;
    result.statistics += worker->sums;
    result.contacts.insert(result.contacts.end(), worker->contacts.begin(), worker->contacts.end());
  }
  std::vector<Contact>& contacts = result.contacts;
  std::sort(contacts.begin(), contacts.end(), canonical_less);
  const std::size_t found = contacts.size();
  contacts.erase(std::unique(contacts.begin(), contacts.end(),
                             [](const Contact& x, const Contact& y) {
                               return x.kind == y.kind && x.vertices == y.vertices;
                             }),
                 contacts.end());
  result.statistics.duplicates = found - contacts.size();
  if (query_ == Query::first && !contacts.empty()) {
    const auto earliest = std::min_element(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
      return x.toi != y.toi ? x.toi < y.toi : canonical_less(x, y);
    });
    contacts = {*earliest};
  }
  for (const Contact& contact : contacts)
    result.statistics.earliest_toi = std::min(result.statistics.earliest_toi, contact.toi);
  result.statistics.contacts = contacts.size();
  collect_overlaps(result);
}

void Pipeline::Run::collect_overlaps(StepResult& result) const {
  std::vector<ElementPair>& overlaps = result.initial_overlaps;
  overlaps.clear();
  for (const auto& worker : data_.workers)
    overlaps.insert(overlaps.end(), worker->overlaps.begin(), worker->overlaps.end());
  std::sort(overlaps.begin(), overlaps.end());
  result.statistics.initial_overlaps = overlaps.size();
}

}  // namespace volccd
