#include <volccd/distributed/in_process_detector.hpp>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/distributed/parts.hpp>

namespace volccd::distributed {

namespace {

void check_request(const Request& request, const Topology& topology, const Motion& motion) {
  if (request.ends || request.tests || request.candidates || request.observer)
    throw ConfigError("ranks: ends of contacts, given tests, candidates and observers are not supported");
  const Mesh& mesh = topology.mesh();
  if (motion.vertex_count() != mesh.vertex_count())
    throw InputError("step", "motion",
                     fmt::format("moves {} vertices, the mesh has {}", motion.vertex_count(), mesh.vertex_count()));
}

void check_shell_vertices(const Mesh& mesh) {
  bool groups = mesh.vertex_count() % 3 == 0;
  for (Index v = 0; groups && v < mesh.vertex_count(); ++v)
    groups = mesh.vertex_id(v) == mesh.vertex_id(v / 3 * 3) + v % 3 && mesh.vertex_id(v / 3 * 3) % 3 == 0;
  if (!groups)
    throw ConfigError(fmt::format(
        "shell neighbours can be left out of thickened shells only: the {} vertices of the mesh do not have the ids "
        "3 i, 3 i + 1 and 3 i + 2 for each vertex of a shell mesh",
        mesh.vertex_count()));
}

Contact to_contact(const RankContact& found, const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  Contact contact{.kind = found.kind,
                  .vertices = {},
                  .toi = found.toi,
                  .normal = found.normal,
                  .weights = found.weights,
                  .point = found.point,
                  .at_start = found.at_start,
                  .gap = found.gap};
  for (std::size_t i = 0; i < 4; ++i)
    contact.vertices[i] =
        static_cast<Index>(std::ranges::lower_bound(mesh.vertex_ids(), found.vertices[i]) - mesh.vertex_ids().begin());
  for (std::size_t i = 0; i < 2; ++i) contact.elements[i] = mesh.find_element(found.elements[i]);
  const auto& [a, b, c, d] = contact.vertices;
  contact.features = contact.kind == FeatureKind::vf ? FeaturePair{a, features.find_triangle(b, c, d)}
                                                     : FeaturePair{features.find_edge(a, b), features.find_edge(c, d)};
  return contact;
}

/// From sums over `ranks` of them: a step is fresh if it was fresh on one of the ranks; otherwise it made a list,
/// refreshed one, or used one, if one of the ranks did, in this order.
void count_lists(Statistics& sums, std::uint64_t ranks) {
  bool counted = sums.list_steps + sums.refreshed_steps + sums.reused_steps < ranks;
  for (std::uint64_t* const steps : {&sums.list_steps, &sums.refreshed_steps, &sums.reused_steps}) {
    *steps = *steps > 0 && !counted ? 1 : 0;
    counted = counted || *steps > 0;
  }
}

}  // namespace

struct InProcessDetector::Rank {
  Rank(Exchange& exchange, const Registry& registry, const PipelineSpec& spec, const Config& config)
      : detector(exchange, registry, spec, config) {}

  Detector detector;
  Motion motion;  ///< of its vertices
};

InProcessDetector::InProcessDetector(int ranks, const Registry& registry, const PipelineSpec& spec,
                                     const Config& config)
    : leave_out_shell_neighbours_(config.leave_out_shell_neighbours),
      in_process_(ranks),
      ranks_(static_cast<std::size_t>(ranks)) {
  in_process_.run([&](Exchange& exchange) {
    ranks_[static_cast<std::size_t>(exchange.rank())] = std::make_unique<Rank>(exchange, registry, spec, config);
  });
}

InProcessDetector::~InProcessDetector() = default;
InProcessDetector::InProcessDetector(InProcessDetector&&) noexcept = default;
InProcessDetector& InProcessDetector::operator=(InProcessDetector&&) noexcept = default;

const Regions& InProcessDetector::regions() const { return ranks_.front()->detector.regions(); }
const Pipeline& InProcessDetector::pipeline() const { return ranks_.front()->detector.pipeline(); }
double InProcessDetector::separation() const { return ranks_.front()->detector.separation(); }
void InProcessDetector::set_separation(double separation) {
  for (const auto& rank : ranks_) rank->detector.set_separation(separation);
}

const StepResult& InProcessDetector::step(const Topology& topology, const Motion& motion, const Request& request) {
  check_request(request, topology, motion);
  if (leave_out_shell_neighbours_) check_shell_vertices(topology.mesh());
  // If this step fails, the next one gives the ranks its topology, whichever they have then.
  const bool same_mesh = std::exchange(version_, 0) == topology.version();
  in_process_.run([&](Exchange& exchange) { step_of_rank(exchange, topology, motion, request, same_mesh); });
  version_ = topology.version();
  result_ = {};
  statistics_.clear();
  for (const auto& rank : ranks_) {
    append(rank->detector.result(), topology);
    statistics_.push_back(rank->detector.result().rank);
  }
  finish();
  return result_;
}

void InProcessDetector::step_of_rank(Exchange& exchange, const Topology& topology, const Motion& motion,
                                     const Request& request, bool same_mesh) {
  Rank& rank = *ranks_[static_cast<std::size_t>(exchange.rank())];
  const Mesh& mesh = topology.mesh();
  const PartRange vertices = part_of(mesh.vertex_count(), exchange.rank(), exchange.size());
  if (!same_mesh) {
    const auto ids = mesh.vertex_ids().subspan(vertices.begin, vertices.size());
    rank.detector.set_mesh(elements_in(mesh, part_of(mesh.element_slots(), exchange.rank(), exchange.size())),
                           {ids.begin(), ids.end()}, topology.features().edge_set());
  }
  copy_motion(motion, vertices, rank.motion);
  rank.detector.step(rank.motion, request);
}

/// Appends what a rank found, with slots of the topology.
void InProcessDetector::append(const RankResult& found, const Topology& topology) {
  for (const RankContact& contact : found.contacts) result_.contacts.push_back(to_contact(contact, topology));
  for (const auto& pair : found.initial_overlaps) {
    const Index a = topology.mesh().find_element(pair[0]), b = topology.mesh().find_element(pair[1]);
    result_.initial_overlaps.push_back({std::min(a, b), std::max(a, b)});
  }
  if (found.rank.elements == 0) return;
  const std::size_t bytes = result_.statistics.workspace_bytes + found.statistics.workspace_bytes;
  result_.statistics += found.statistics;
  result_.statistics.workspace_bytes = bytes;
}

/// Sets the order of the result, and the counts that are not sums of those of the ranks.
void InProcessDetector::finish() {
  const auto less = [](const Contact& x, const Contact& y) { return volccd::canonical_less(x, y); };
  std::ranges::sort(result_.contacts, less);
  if (std::ranges::adjacent_find(result_.contacts, std::not_fn(less)) != result_.contacts.end())
    throw std::logic_error("two ranks found the same contact");
  std::ranges::sort(result_.initial_overlaps);
  Statistics& statistics = result_.statistics;
  count_lists(statistics, statistics.steps);  // each rank that has elements counts one
  statistics.steps = 1;
  statistics.contacts = result_.contacts.size();
  statistics.contacts_at_start =
      static_cast<std::uint64_t>(std::ranges::count_if(result_.contacts, &Contact::at_start));
  statistics.initial_overlaps = result_.initial_overlaps.size();
}

}  // namespace volccd::distributed
