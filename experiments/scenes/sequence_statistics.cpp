#include <volccd/experiments/scenes/sequence_statistics.hpp>

#include <algorithm>

#include <nlohmann/json.hpp>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pipelines/registry.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

namespace {

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void measure_motion(const Features& features, const Motion& motion, StepStatistics& out) {
  double sum = 0;
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty())
      sum += (motion.point(features.edge(e)[0], 0) - motion.point(features.edge(e)[1], 0)).norm();
  if (features.edge_count() > 0) out.mean_edge = sum / features.edge_count();
  std::vector<double> moved;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty())
      moved.push_back((motion.point(v, motion.degree()) - motion.point(v, 0)).norm() / std::max(out.mean_edge, 1e-300));
  out.median_motion = quantile(moved, 0.5);
  out.p99_motion = quantile(moved, 0.99);
  out.largest_motion = quantile(moved, 1);
}

bool share_vertex(const Mesh& mesh, Index a, Index b) {
  for (const Index v : mesh.vertices(a))
    for (const Index w : mesh.vertices(b))
      if (v == w) return true;
  return false;
}

void count_contact(const Mesh& mesh, const Features& features, const Contact& contact, ContactCounts& out) {
  const auto& v = contact.vertices;
  const bool vf = contact.kind == FeatureKind::vf;
  const auto a = vf ? features.vertex_elements(v[0]) : features.edge_elements(features.find_edge(v[0], v[1]));
  const auto b = vf ? features.triangle_elements(features.find_triangle(v[1], v[2], v[3]))
                    : features.edge_elements(features.find_edge(v[2], v[3]));
  const bool apart = std::any_of(a.begin(), a.end(), [&](Index x) {
    return std::any_of(b.begin(), b.end(), [&](Index y) { return !share_vertex(mesh, x, y); });
  });
  if (!apart)
    ++out.adjacent;
  else if (mesh.object(a[0]) != mesh.object(b[0]))
    ++out.inter;
  else
    ++out.intra;
}

}  // namespace

std::vector<StepStatistics> sequence_statistics(SequenceReader& reader, Executor& executor,
                                                const std::function<bool(int)>& go_on) {
  SequenceStepper::Config config;
  if (reader.has_thickness()) config.shells = ShellModel::solid;
  SequenceStepper stepper(reader, config);
  const Registry registry = Registry::standard();
  StepRunner runner(Pipeline(registry, registry.pipeline("VolCCD+")),
                    {.executor = &executor, .leave_out_shell_neighbours = config.shells == ShellModel::solid});
  SequenceCells before, cells;
  reader.read_cells(0, before);
  std::vector<StepStatistics> steps;
  for (int k = 0; k < stepper.step_count(); ++k) {
    StepStatistics& step = steps.emplace_back();
    step.time = reader.time(k);
    reader.read_cells(k + 1, cells);
    for (const ElementType type : cells.types) ++step.elements[type];
    if (!reader.same_cells(k, k + 1)) {
      const TopologyEdit edit = edit_to(mesh_of(reader.point_ids(), before), cells);
      step.removed = edit.removed.size();
      step.added = edit.added.size();
    }
    std::swap(before, cells);
    stepper.go_to(k, executor);
    const Topology& topology = stepper.topology();
    measure_motion(topology.features(), stepper.motion(), step);
    const StepResult& result = runner.run(topology, stepper.motion());
    step.contacts_at_start = result.statistics.contacts_at_start;
    for (const Contact& contact : result.contacts)
      count_contact(topology.mesh(), topology.features(), contact, step.contacts);
    if (go_on && !go_on(k + 1)) break;
  }
  return steps;
}

nlohmann::json to_json(const std::vector<StepStatistics>& steps) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const StepStatistics& m = steps[k];
    nlohmann::json elements = nlohmann::json::object();
    for (const auto& [type, count] : m.elements) elements[to_string(type)] = count;
    list.push_back(
        {{"step", k},
         {"time", m.time},
         {"elements", std::move(elements)},
         {"removed", m.removed},
         {"added", m.added},
         {"mean_edge", m.mean_edge},
         {"moved_edges", {{"median", m.median_motion}, {"p99", m.p99_motion}, {"largest", m.largest_motion}}},
         {"contacts", {{"inter", m.contacts.inter}, {"intra", m.contacts.intra}, {"adjacent", m.contacts.adjacent}}},
         {"contacts_at_start", m.contacts_at_start}});
  }
  return list;
}

}  // namespace volccd
