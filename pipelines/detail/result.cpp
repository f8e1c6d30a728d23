#include <volccd/pipelines/detail/result.hpp>

#include <algorithm>
#include <span>
#include <utility>

#include <volccd/core/sort_unique.hpp>
#include <volccd/narrowphase/contact_frame.hpp>

namespace volccd::detail {

namespace {

/// Usually the first one, which is in an array of its own: contacts are at random places of the mesh.
Index element_of_smallest_id(const Mesh& mesh, Index first, std::span<const Index> elements) {
  if (mesh.element_ids_ascend()) return first;
  Index smallest = first;
  for (const Index o : elements)
    if (mesh.element_id(o) < mesh.element_id(smallest)) smallest = o;
  return smallest;
}

/// An EE test has the edge of smaller slot first, a contact the edge with the smaller vertices.
void complete(Contact& contact, const Topology& topology) {
  const Features& features = topology.features();
  auto& [a, b] = contact.features;
  if (contact.kind == FeatureKind::ee && features.edge(a)[0] != contact.vertices[0]) std::swap(a, b);
  const bool vf = contact.kind == FeatureKind::vf;
  const Mesh& mesh = topology.mesh();
  const auto of_edge = [&](Index e) {
    return element_of_smallest_id(mesh, features.first_element_of_edge(e), features.edge_elements(e));
  };
  contact.elements = {
      vf ? element_of_smallest_id(mesh, features.first_element_of_vertex(a), features.vertex_elements(a)) : of_edge(a),
      vf ? element_of_smallest_id(mesh, features.first_element_of_triangle(b), features.triangle_elements(b))
         : of_edge(b)};
}

/// Sets StepResult::ends to the contacts at the end of the step.
void find_ends(StepResult& result, const Motion& motion, Executor& executor) {
  result.ends.resize(result.contacts.size());
  executor.parallel_for(result.contacts.size(), 256, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const Contact& contact = result.contacts[i];
      result.ends[i] = contact_end(contact.kind, test_points(motion, contact.vertices), motion.control_points());
    }
  });
}

}  // namespace

void ResultMerger::merge(std::span<const std::unique_ptr<WorkerScratch>> workers, Executor& executor,
                         StepResult& result) {
  result.statistics = {};
  result.initial_overlaps.clear();
  contacts_of_.clear();
  for (const auto& worker : workers) {
    worker->end_step();
    result.statistics += worker->sums;
    contacts_of_.push_back(worker->chain.contacts());
    result.initial_overlaps.insert(result.initial_overlaps.end(), worker->overlaps.begin(), worker->overlaps.end());
  }
  result.statistics.duplicates = order_.collect(contacts_of_, executor, result.contacts);
  std::sort(result.initial_overlaps.begin(), result.initial_overlaps.end());
}

void ResultMerger::merge_collected(std::span<const std::unique_ptr<WorkerScratch>> workers, TestBatch& tests) {
  tests.clear();
  for (const auto& worker : workers) {
    const TestBatch& part = worker->chain.collected();
    tests.vf.insert(tests.vf.end(), part.vf.begin(), part.vf.end());
    tests.ee.insert(tests.ee.end(), part.ee.begin(), part.ee.end());
  }
  sort_unique(tests.vf);
  sort_unique(tests.ee);
}

void keep_earliest(std::vector<Contact>& contacts) {
  if (contacts.empty()) return;
  const auto earliest = std::min_element(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
    return x.toi != y.toi ? x.toi < y.toi : canonical_less(x, y);
  });
  contacts = {*earliest};
}

void complete(StepResult& result, const Step& step, bool ends, Executor& executor) {
  Statistics& statistics = result.statistics;
  result.ends.clear();
  if (ends) find_ends(result, step.motion, executor);
  for (Contact& contact : result.contacts) {
    complete(contact, step.topology);
    statistics.earliest_toi = std::min(statistics.earliest_toi, contact.toi);
    statistics.contacts_at_start += contact.at_start ? 1 : 0;
  }
  statistics.contacts = result.contacts.size();
  statistics.initial_overlaps = result.initial_overlaps.size();
}

}  // namespace volccd::detail
