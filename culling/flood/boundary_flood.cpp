#include <volccd/culling/flood/boundary_flood.hpp>

#include <algorithm>
#include <optional>
#include <utility>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/flood/detail/flood_front.hpp>
#include <volccd/culling/flood/detail/outer_parts.hpp>
#include <volccd/culling/flood/detail/simplex_complex.hpp>
#include <volccd/culling/stars/suspect_orphans.hpp>
#include <volccd/culling/stars/suspect_pairs.hpp>

namespace volccd {

namespace {

enum class Phase { idle, start, flood };

struct alignas(64) Worker {
  std::vector<ElementPair> reached;
  std::size_t bytes() const { return heap_bytes(reached); }
};

struct BoundaryFloodState final : StageState {
  detail::SimplexComplex complex;
  detail::VertexStars stars;
  detail::SuspectPairs suspects;
  detail::SuspectOrphans orphans;
  detail::OuterParts outer;
  TopologyDelta counted;  ///< the topology for which the shares were computed
  double boundary_share = 0, divided_share = 0;
  ObjectFilter filter;
  std::optional<Step> step;  ///< the step of the complex
  bool taken = false;
  std::uint64_t neighbours_version = 0;  ///< the version of the subset to which the neighbours in start_scratch belong
  detail::StartScratch start_scratch;
  detail::PairSet seen, seen_at_start;
  std::vector<ElementPair> front, reached;
  std::size_t seeds = 0;  ///< how many of the reached pairs are seeds, which are culled for the whole step at once
  std::vector<Worker> workers;
  Phase phase = Phase::idle;
  BoundaryFlood::Counters counters;

  std::size_t bytes() const override {
    return heap_bytes(complex, stars, suspects, orphans, outer, counted, start_scratch, seen, seen_at_start, front,
                      reached, workers);
  }
};

BoundaryFloodState& own(StageState& state) { return static_cast<BoundaryFloodState&>(state); }
const BoundaryFloodState& own(const StageState& state) { return static_cast<const BoundaryFloodState&>(state); }

/// The share of elements for which the predicate is true; 1 if there are none.
template <class Predicate>
double share_of_elements(const Mesh& mesh, Predicate&& predicate) {
  std::size_t count = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) count += mesh.is_live(o) && predicate(o) ? 1 : 0;
  return mesh.element_count() == 0 ? 1 : static_cast<double>(count) / static_cast<double>(mesh.element_count());
}

/// The share of elements that are shells or have a face without another element.
double boundary_share(const Topology& topology) {
  const Features& features = topology.features();
  return share_of_elements(topology.mesh(), [&](Index o) {
    const std::span<const Index> triangles = features.element_triangles(o);
    return is_shell(topology.mesh().type(o)) || std::any_of(triangles.begin(), triangles.end(), [&](Index f) {
             return features.triangle_elements(f).size() == 1;
           });
  });
}

/// The share of elements that have to be divided into tetrahedra.
double divided_share(const Mesh& mesh) {
  return share_of_elements(
      mesh, [&](Index o) { return !is_shell(mesh.type(o)) && mesh.type(o) != ElementType::tetrahedron; });
}

/// The seeds at t = 0, and the adjacent pairs that may have double points then.
void propose_from_start(BoundaryFloodState& state, std::span<const ElementPair> seeds, detail::FloodFront& front,
                        Executor& executor) {
  const std::uint64_t version = state.outer.subset().version();
  if (std::exchange(state.neighbours_version, version) != version)
    state.start_scratch.neighbours.clear(state.step->mesh().element_slots());
  front.propose_containing(state.outer.chosen_vertices(), state.start_scratch, executor);
  for (const ElementPair pair : state.suspects.pairs())
    if (pair.a != pair.b && !front.apart_at_start(pair)) front.propose_neighbours_at_start(pair, state.start_scratch);
  for (const ElementPair pair : seeds) front.propose(pair);
}

/// The pairs to process next.
Flood::Front propose(BoundaryFloodState& state, Executor& executor) {
  const Step& step = *state.step;
  state.front.clear();
  const std::size_t begin = state.reached.size();
  for (Worker& worker : state.workers) {
    state.reached.insert(state.reached.end(), worker.reached.begin(), worker.reached.end());
    worker.reached.clear();
  }
  const std::span<const ElementPair> fresh = std::span(state.reached).subspan(begin);
  const detail::StarTable& table = state.stars.table();
  if (state.phase != Phase::flood) {
    detail::FloodFront at_start(step, table, state.seen_at_start, state.front);
    if (state.phase == Phase::idle) state.seeds = fresh.size();
    if (state.phase == Phase::idle)
      propose_from_start(state, fresh, at_start, executor);
    else
      for (const ElementPair pair : fresh) at_start.propose_neighbours_at_start(pair, state.start_scratch);
    state.phase = Phase::start;
    if (!state.front.empty()) return {state.front, true};
  }
  detail::FloodFront front(step, table, state.seen, state.front);
  if (state.phase == Phase::start) {
    const std::span<const ElementPair> all(state.reached), seeds = all.first(state.seeds);
    for (const ElementPair pair : seeds) state.seen.insert(pair);
    for (const ElementPair pair : seeds) front.propose_neighbours(pair);
    for (const ElementPair pair : state.suspects.pairs())
      if (pair.a != pair.b) front.propose_neighbours(pair);
    for (const ElementPair pair : all.subspan(state.seeds)) front.propose(pair);  // so far culled for t = 0 only
    state.phase = Phase::flood;
  } else {
    for (const ElementPair pair : fresh) front.propose_neighbours(pair);
  }
  return {state.front, false};
}

}  // namespace

const Options<BoundaryFlood::Config>& BoundaryFlood::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("max_boundary_fraction", &Config::max_boundary_fraction, 0, 1,
               "share of elements on the boundary above which a step is left to the other stages")
          .add("max_divided_fraction", &Config::max_divided_fraction, 0, 1,
               "share of elements that have to be divided into tetrahedra above which a step is left to the other "
               "stages")
          .add("max_suspect_fraction", &Config::max_suspect_fraction, 0, 1,
               "share of vertices whose stars may fold above which a step is left to the other stages")
          .add("max_pairs", &Config::max_pairs, 0, 1e9,
               "pairs looked at for each simplex, above which a step is begun anew by the other stages")
          .renamed("most_boundary", "max_boundary_fraction")
          .renamed("most_divided", "max_divided_fraction")
          .renamed("most_suspect", "max_suspect_fraction")
          .renamed("most_pairs", "max_pairs");
  return options;
}

std::unique_ptr<StageState> BoundaryFlood::make_state() const { return std::make_unique<BoundaryFloodState>(); }

void BoundaryFlood::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  BoundaryFloodState& state = own(stage_state);
  state.taken = false;
  state.phase = Phase::idle;
  state.counters = {};
  if (state.counted.sync(step.topology) != TopologyDelta::Extent::none) {
    state.boundary_share = boundary_share(step.topology);
    state.divided_share = divided_share(step.mesh());
  }
  state.counted.confirm();
  if (state.boundary_share > config_.max_boundary_fraction || state.divided_share > config_.max_divided_fraction) return;
  state.complex.update(step.topology, executor);
  const Topology& topology = state.complex.topology();
  // Object ids change along a chain of pairs only where objects share vertices. In that case only the tests are
  // filtered.
  state.filter = topology.objects_share_vertices() ? ObjectFilter() : step.filter;
  state.step.emplace(Step{topology, step.motion, state.filter, step.separation, step.t_max, &state.outer.subset()});
  // An edit changes which outer parts are next to each other, also if no part changes, as when an element is replaced in
  // its slot.
  if (state.stars.update(*state.step, executor) != TopologyDelta::Extent::none) state.neighbours_version = 0;
  state.counters.simplices = topology.mesh().element_count();
  state.counters.suspect_vertices = state.stars.suspects().size();
  if (static_cast<double>(state.counters.suspect_vertices) >
      config_.max_suspect_fraction * static_cast<double>(topology.features().vertex_count()))
    return;
  state.suspects.update(*state.step, state.stars, executor, [](Index, Index) { return true; });
  state.orphans.update(topology, state.suspects.pairs(), executor);
  state.outer.update(*state.step, state.stars);
  state.counters.paired = state.outer.subset().size();
  state.workers.resize(executor.workers());
  for (Worker& worker : state.workers) worker.reached.clear();
  state.reached.clear();
  state.seen.clear();
  state.seen_at_start.clear();
  state.taken = true;
}

bool BoundaryFlood::takes(const StageState& state, bool overlaps) const {
  return own(state).taken && (!overlaps || own(state).complex.is_mesh());
}

Step BoundaryFlood::step(const StageState& state) const { return *own(state).step; }

void BoundaryFlood::reach(StageState& state, unsigned worker, const std::vector<ElementPair>& pairs) const {
  std::vector<ElementPair>& reached = own(state).workers[worker].reached;
  reached.insert(reached.end(), pairs.begin(), pairs.end());
}

Flood::Front BoundaryFlood::next(StageState& state, Executor& executor) const {
  Front front = propose(own(state), executor);
  Counters& counters = own(state).counters;
  counters.looked_at += front.pairs.size();
  if (front.at_start) counters.looked_at_start += front.pairs.size();
  const double max = config_.max_pairs * static_cast<double>(counters.simplices);
  front.given_up = static_cast<double>(counters.looked_at) > max;
  return front;
}

void BoundaryFlood::to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                     std::size_t ee_begin) const {
  own(state).complex.to_mesh_features(tests, vf_begin, ee_begin);
}

std::size_t BoundaryFlood::orphan_blocks(const StageState& state) const { return own(state).orphans.blocks(); }

void BoundaryFlood::orphans(const StageState& stage_state, std::size_t block, TestBatch& out) const {
  const BoundaryFloodState& state = own(stage_state);
  const std::size_t vf_begin = out.vf.size(), ee_begin = out.ee.size();
  state.orphans.append(block, out);
  state.complex.to_mesh_features(out, vf_begin, ee_begin);
}

const BoundaryFlood::Counters& BoundaryFlood::counters(const StageState& state) { return own(state).counters; }

StageDescriptor<Flood> describe_boundary_flood() {
  return describe_stage<Flood, BoundaryFlood>(
      "boundary-flood", "all contacts of volumes, reached from pairs of boundary elements", Guarantee::conservative);
}

}  // namespace volccd
