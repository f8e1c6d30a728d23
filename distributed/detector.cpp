#include <volccd/distributed/detector.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/distributed/piece_mesh.hpp>
#include <volccd/distributed/region_filter.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd::distributed {

namespace {

/// Elements whose boxes a worker computes in one go.
constexpr std::size_t kBoxes = 1024;

/// The registry with the filter of a region, and the pipeline with it as last filter.
Pipeline make_pipeline(Registry registry, PipelineSpec spec, const Region& region) {
  registry.add(describe_region_filter(region));
  spec.feature_filters.push_back({"region"});
  return Pipeline(registry, spec);
}

/// Finite, although a bound that a separation enlarges may be infinite.
Vec3 centre(const Box& box) {
  constexpr double kMax = std::numeric_limits<double>::max();
  return box.low.cwiseMax(-kMax) / 2 + box.high.cwiseMin(kMax) / 2;
}

Box start_box(const Mesh& mesh, Index element, const Motion& motion) {
  Box box;
  extend(box, motion, mesh.vertices(element), 1);
  return box;
}

void check_request(const Request& request, const Topology& topology, const Motion& motion) {
  if (request.ends || request.tests || request.candidates || request.observer)
    throw ConfigError("ranks: ends of contacts, given tests, candidates and observers are not supported");
  const Index vertices = topology.mesh().vertex_count();
  if (motion.vertex_count() != vertices)
    throw InputError("step", "motion",
                     fmt::format("moves {} vertices, the mesh has {}", motion.vertex_count(), vertices));
  if (request.leave_out_shell_neighbours && vertices % 3 != 0)
    throw ConfigError(fmt::format(
        "shell neighbours can be left out of thickened shells only: the mesh has {} vertices, not three for each "
        "vertex of a shell mesh",
        vertices));
}

}  // namespace

struct Detector::Rank {
  Rank(const Registry& registry, const PipelineSpec& spec)
      : pipeline(make_pipeline(registry, spec, region)), workspace(pipeline.make_workspace()) {}

  Region region;  ///< the region filter refers to it
  Pipeline pipeline;
  Workspace workspace;
  PieceMesh piece;
  std::vector<Index> elements;  ///< of this step: slots of the whole, ascending
};

RankStatistics& RankStatistics::operator+=(const RankStatistics& other) {
  elements += other.elements;
  copies += other.copies;
  tests += other.tests;
  contacts += other.contacts;
  seconds += other.seconds;
  piece_seconds += other.piece_seconds;
  return *this;
}

Detector::Detector(const Registry& registry, const PipelineSpec& spec, const Config& config)
    : executor_(config.executor ? config.executor : &serial_executor()), filter_(config.filter) {
  set_separation(config.separation);
  if (config.ranks < 1) throw ConfigError(fmt::format("ranks: {}, but there must be one at least", config.ranks));
  for (int r = 0; r < config.ranks; ++r) ranks_.push_back(std::make_unique<Rank>(registry, spec));
  if (pipeline().guarantee() == Guarantee::approximate)
    throw ConfigError(
        fmt::format("ranks: pipeline {} may lose contacts, and other ones on other numbers of ranks", spec.name));
}

Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

const Pipeline& Detector::pipeline() const { return ranks_.front()->pipeline; }

void Detector::set_separation(double separation) {
  if (!(separation >= 0) || !std::isfinite(separation))
    throw ConfigError(fmt::format("separation: {} is not a finite number >= 0", separation));
  separation_ = separation;
}

const StepResult& Detector::step(const Topology& topology, const Motion& motion, const Request& request) {
  check_request(request, topology, motion);
  make_boxes(topology, motion);
  assign_elements(topology.mesh());
  result_ = {};
  for (std::size_t r = 0; r < ranks_.size(); ++r) {
    run_rank(*ranks_[r], statistics_[r], topology, motion, request);
    append(*ranks_[r], topology, motion);
  }
  finish(request);
  return result_;
}

void Detector::make_boxes(const Topology& topology, const Motion& motion) {
  const Mesh& mesh = topology.mesh();
  boxes_.resize(mesh.element_slots());
  executor_->parallel_for(boxes_.size(), kBoxes, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t o = begin; o < end; ++o) {
      Box box;
      extend(box, motion, mesh.vertices(static_cast<Index>(o)), motion.control_points());
      boxes_[o] = enlarged(box, separation_);
    }
  });
}

/// Gives each element to the ranks whose regions its box meets, and makes the regions in the first step.
void Detector::assign_elements(const Mesh& mesh) {
  if (!divided_) {
    std::vector<Vec3> centres;
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o)) centres.push_back(centre(boxes_[o]));
    regions_ = Regions(centres, std::vector<double>(centres.size(), 1), static_cast<int>(ranks_.size()));
    for (std::size_t r = 0; r < ranks_.size(); ++r) ranks_[r]->region = regions_.region(static_cast<int>(r));
    divided_ = true;
  }
  statistics_.assign(ranks_.size(), {});
  for (const auto& rank : ranks_) rank->elements.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    const int home = regions_.at(centre(boxes_[o]));
    regions_.meeting(boxes_[o], [&](int r) {
      ranks_[static_cast<std::size_t>(r)]->elements.push_back(o);
      statistics_[static_cast<std::size_t>(r)].copies += r != home;
    });
  }
}

void Detector::run_rank(Rank& rank, RankStatistics& statistics, const Topology& topology, const Motion& motion,
                        const Request& request) {
  rank_result_ = {};
  statistics.elements = rank.elements.size();
  if (rank.elements.empty()) return;
  const Motion* moved = nullptr;
  {
    StageClock clock;
    const StageTimer timer(clock, statistics.piece_seconds);
    rank.piece.update(topology, rank.elements, request.leave_out_shell_neighbours ? 3 : 1, *executor_);
    moved = &rank.piece.motion_of(motion);
  }
  const Step step{rank.piece.topology(), *moved, filter_, separation_};
  rank.pipeline.run(step, rank.workspace, *executor_, rank_result_, request);
  statistics.tests = rank_result_.statistics.tests();
  statistics.contacts = rank_result_.contacts.size();
  statistics.seconds = rank_result_.statistics.seconds;
}

/// Appends what the rank found, with slots of the whole.
void Detector::append(Rank& rank, const Topology& topology, const Motion& motion) {
  if (rank.elements.empty()) return;
  const PieceMesh& piece = rank.piece;
  const Features& features = topology.features();
  const auto append_contacts = [&](std::span<const Contact> found, std::vector<Contact>& all) {
    for (Contact contact : found) {
      for (Index& v : contact.vertices) v = piece.whole_vertex(v);
      for (Index& o : contact.elements) o = piece.whole_element(o);
      const auto& [a, b, c, d] = contact.vertices;
      contact.features = contact.kind == FeatureKind::vf
                             ? FeaturePair{a, features.find_triangle(b, c, d)}
                             : FeaturePair{features.find_edge(a, b), features.find_edge(c, d)};
      all.push_back(contact);
    }
  };
  append_contacts(rank_result_.contacts, result_.contacts);
  append_contacts(rank_result_.left_out, result_.left_out);
  for (const ElementPair pair : rank_result_.initial_overlaps) {
    const auto [a, b] = std::minmax({piece.whole_element(pair.a), piece.whole_element(pair.b)});
    const Mesh& mesh = topology.mesh();
    const Vec3 point = reference_point(start_box(mesh, a, motion).low, start_box(mesh, b, motion).low, separation_);
    if (rank.region.contains(point)) result_.initial_overlaps.push_back({a, b});
  }
  const std::size_t bytes = result_.statistics.workspace_bytes + rank_result_.statistics.workspace_bytes;
  result_.statistics += rank_result_.statistics;
  result_.statistics.workspace_bytes = bytes;
}

/// Sets the order of the result, and the counts that are not sums of those of the ranks.
void Detector::finish(const Request& request) {
  const auto sort = [](std::vector<Contact>& contacts) {
    std::ranges::sort(contacts, canonical_less);
    if (std::ranges::adjacent_find(
            contacts, [](const Contact& x, const Contact& y) { return !canonical_less(x, y); }) != contacts.end())
      throw std::logic_error("two ranks found the same contact");
  };
  sort(result_.contacts);
  sort(result_.left_out);
  std::ranges::sort(result_.initial_overlaps);
  if (request.query == Query::first && !result_.contacts.empty())
    result_.contacts = {*std::ranges::min_element(result_.contacts, {}, &Contact::toi)};  // the first of equal ones
  Statistics& statistics = result_.statistics;
  statistics.steps = 1;
  statistics.contacts = result_.contacts.size();
  statistics.contacts_at_start =
      static_cast<std::uint64_t>(std::ranges::count_if(result_.contacts, &Contact::at_start));
  statistics.initial_overlaps = result_.initial_overlaps.size();
}

}  // namespace volccd::distributed
