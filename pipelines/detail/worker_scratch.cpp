#include <volccd/pipelines/detail/worker_scratch.hpp>

#include <algorithm>
#include <utility>

namespace volccd::detail {

void WorkerScratch::begin_step(const PipelineSpec& spec) {
  work.pairs.clear();
  work.tests.clear();
  overlaps.clear();
  std::vector<StageStatistics> stages = std::move(sums.stages);
  if (stages.empty()) {
    for (const auto& [role, choice] : spec.stages()) stages.push_back({role, choice->name});
    stages.push_back({"initial-overlaps", "hulls"});
  }
  for (StageStatistics& stage : stages) {
    stage.counters.clear();
    stage = {std::move(stage.role), std::move(stage.name), std::move(stage.counters)};
  }
  sums = {};
  sums.stages = std::move(stages);
}

void WorkerScratch::end_step() {
  sums.vf_tests = chain.tests(FeatureKind::vf);
  sums.ee_tests = chain.tests(FeatureKind::ee);
  sums.degenerate = chain.counters().degenerate;
  sums.undecided = chain.counters().undecided;
}

void WorkerScratch::test_overlaps(const Step& step) {
  StageStatistics& statistics = sums.stages.back();
  const StageTimer timer(chain.clock(), statistics.seconds);
  const Mesh& mesh = step.mesh();
  overlap_candidates.clear();
  for (const auto* list : {&batch.pairs, &batch.contact_free})
    for (const ElementPair pair : *list)
      if ((step.range == PairRange::nonadjacent || !step.adjacency().adjacent(pair.a, pair.b)) &&
          step.filter.allows(mesh.object(pair.a), mesh.object(pair.b)))
        overlap_candidates.push_back(pair);
  const std::size_t before = overlaps.size();
  overlap_test.find(step, overlap_candidates, overlaps);
  statistics.in += overlap_candidates.size();
  statistics.out += overlaps.size() - before;
}

void WorkerScratch::run_tests(std::size_t multiple, EarliestTime& earliest) {
  const std::size_t old_contacts = chain.contacts().size();
  chain.prune(earliest.limit());
  const auto run = [&](FeatureKind kind, std::vector<FeaturePair>& tests) {
    const std::size_t rest = tests.size() % multiple;
    chain.add(kind, std::span(tests).subspan(rest));
    tests.resize(rest);
  };
  run(FeatureKind::vf, work.tests.vf);
  run(FeatureKind::ee, work.tests.ee);
  earliest.record(chain.contacts(), old_contacts);
}

void WorkerScratch::finish_tests(EarliestTime& earliest) {
  run_tests(1, earliest);
  const std::size_t old_contacts = chain.contacts().size();
  chain.finish();
  earliest.record(chain.contacts(), old_contacts);
}

std::size_t WorkerScratch::bytes() const {
  return sizeof(*this) + heap_bytes(work.pairs, work.tests.vf, work.tests.ee, batch, chain, overlap_test,
                                    overlap_candidates, overlaps, observed, observed_keep);
}

}  // namespace volccd::detail
