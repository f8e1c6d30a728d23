#include <volccd/pipelines/detail/worker_scratch.hpp>

#include <algorithm>
#include <utility>

#include <volccd/query/shell_neighbours.hpp>

namespace volccd::detail {

void WorkerScratch::begin_step(const PipelineSpec& spec) {
  work.pairs.clear();
  work.tests.clear();
  overlaps.clear();
  left_out.clear();
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

void WorkerScratch::run_tests(std::size_t multiple, const Request& request, EarliestTime& earliest) {
  const std::size_t old_contacts = chain.contacts().size();
  chain.prune(earliest.limit());
  const auto run = [&](FeatureKind kind, std::vector<FeaturePair>& tests) {
    const std::size_t rest = tests.size() % multiple;
    chain.add(kind, std::span(tests).subspan(rest));
    tests.resize(rest);
  };
  run(FeatureKind::vf, work.tests.vf);
  run(FeatureKind::ee, work.tests.ee);
  record_contacts(old_contacts, request, earliest);
}

void WorkerScratch::finish_tests(const Request& request, EarliestTime& earliest) {
  run_tests(1, request, earliest);
  const std::size_t old_contacts = chain.contacts().size();
  chain.finish();
  record_contacts(old_contacts, request, earliest);
}

/// Contacts from `old_contacts` on are new. A contact that is left out must not count as the first one.
void WorkerScratch::record_contacts(std::size_t old_contacts, const Request& request, EarliestTime& earliest) {
  std::vector<Contact>& contacts = chain.contacts();
  if (request.leave_out_shell_neighbours) {
    const auto others = std::partition(contacts.begin() + static_cast<std::ptrdiff_t>(old_contacts), contacts.end(),
                                       [](const Contact& c) { return !share_shell_vertex(c.kind, c.vertices); });
    if (request.query != Query::first) left_out.insert(left_out.end(), others, contacts.end());
    contacts.erase(others, contacts.end());
  }
  earliest.record(contacts, old_contacts);
}

std::size_t WorkerScratch::bytes() const {
  return sizeof(*this) + heap_bytes(work.pairs, work.tests.vf, work.tests.ee, batch, chain, overlap_test,
                                    overlap_candidates, overlaps, left_out, observed, observed_keep);
}

}  // namespace volccd::detail
