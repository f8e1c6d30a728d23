#include <volccd/culling/flood/boundary_flood.hpp>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/flood/detail/flood_front.hpp>
#include <volccd/culling/flood/detail/outer_parts.hpp>
#include <volccd/culling/flood/detail/simplex_complex.hpp>
#include <volccd/culling/stars/suspect_orphans.hpp>
#include <volccd/culling/stars/suspect_pairs.hpp>
#include <volccd/culling/stars/suspect_share.hpp>

namespace volccd {

namespace {

/// Pairs of a block in the rounds after the first one.
constexpr std::size_t kPairs = 256;

/// The rounds of a flood: first the pairs of outer parts, then rounds of the flood at t = 0, then rounds of the flood
/// over the whole step, in their place all pairs of simplices if these are too many, and the orphans.
enum class Phase { parts, at_start, flood, everything, orphans };

struct alignas(64) Worker {
  Work work;                          ///< pairs of outer parts, or of all simplices
  std::vector<ElementPair> survived;  ///< of the present round
  std::size_t bytes() const { return heap_bytes(work.pairs, survived); }
};

struct BoundaryFloodState final : StageState {
  explicit BoundaryFloodState(const BroadPhase* broad) : broad_phase(broad) {}

  const BroadPhase* broad_phase;
  std::unique_ptr<StageState> parts_state, simplices_state;  ///< of the broad phase; the second if it was ever needed
  detail::SimplexComplex complex, cut_stars;                 ///< of the topology, and of Piece::cut_stars
  detail::VertexStars stars;
  detail::SuspectPairs suspects;
  detail::SuspectOrphans orphans;
  detail::OuterParts outer;
  TopologyDelta counted;                       ///< the topology for which the shares were computed
  std::vector<std::uint8_t> counted_complete;  ///< Piece::complete of then
  double boundary_share = 0, divided_share = 0;
  ObjectFilter filter;
  std::optional<Step> step, parts_step;  ///< of the complex, and of the outer parts
  bool taken = false;
  std::uint64_t neighbours_version = 0;  ///< the version of the parts to which the neighbours in start_scratch belong
  detail::StartScratch start_scratch;
  detail::PairSet seen, seen_at_start;
  std::vector<ElementPair> front, reached;
  std::size_t seeds = 0;  ///< how many of the reached pairs are seeds, which are culled for the whole step at once
  std::vector<Worker> workers;
  Phase phase = Phase::parts;
  BoundaryFlood::Counters counters;

  std::size_t bytes() const override {
    return (parts_state ? parts_state->bytes() : 0) + (simplices_state ? simplices_state->bytes() : 0) +
           heap_bytes(complex, cut_stars, stars, suspects, orphans, outer, counted, counted_complete, start_scratch,
                      seen, seen_at_start, front, reached, workers);
  }
};

BoundaryFloodState& own(StageState& state) { return static_cast<BoundaryFloodState&>(state); }
const BoundaryFloodState& own(const StageState& state) { return static_cast<const BoundaryFloodState&>(state); }

/// The share of elements with complete vertices for which the predicate is true; 1 if there are none.
template <class Predicate>
double share_of_elements(const Step& step, Predicate&& predicate) {
  const Mesh& mesh = step.mesh();
  std::size_t count = 0, all = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    const std::span<const Index> vertices = mesh.vertices(o);
    if (!mesh.is_live(o) || !std::ranges::all_of(vertices, [&](Index v) { return step.piece.is_complete(v); }))
      continue;
    ++all;
    count += predicate(o) ? 1 : 0;
  }
  return all == 0 ? 1 : static_cast<double>(count) / static_cast<double>(all);
}

/// The share of elements that are shells or have a face without another element.
double boundary_share(const Step& step) {
  const Features& features = step.features();
  return share_of_elements(step, [&](Index o) {
    const std::span<const Index> triangles = features.element_triangles(o);
    return is_shell(step.mesh().type(o)) || std::any_of(triangles.begin(), triangles.end(), [&](Index f) {
             return features.triangle_elements(f).size() == 1;
           });
  });
}

/// The share of elements that have to be divided into tetrahedra.
double divided_share(const Step& step) {
  return share_of_elements(
      step, [&](Index o) { return !is_shell(step.mesh().type(o)) && step.mesh().type(o) != ElementType::tetrahedron; });
}

/// Proposes the seeds at t = 0, and the neighbours of adjacent pairs that may have double points then.
void propose_from_start(BoundaryFloodState& state, std::span<const ElementPair> seeds, detail::FloodFront& front,
                        Executor& executor) {
  const std::uint64_t version = state.outer.table().topology().version();
  if (std::exchange(state.neighbours_version, version) != version)
    state.start_scratch.neighbours.clear(state.step->mesh().element_slots());
  front.propose_containing(state.outer.chosen_vertices(), state.start_scratch, executor);
  for (const ElementPair pair : state.suspects.pairs())
    if (pair.a != pair.b && !front.apart_at_start(pair)) front.propose_neighbours_at_start(pair, state.start_scratch);
  for (const ElementPair pair : seeds) front.propose(pair);
}

/// Moves the survivors of the last round to `reached`, and returns them there.
std::span<const ElementPair> collect_survivors(BoundaryFloodState& state) {
  const std::size_t begin = state.reached.size();
  for (Worker& worker : state.workers) {
    state.reached.insert(state.reached.end(), worker.survived.begin(), worker.survived.end());
    worker.survived.clear();
  }
  return std::span(state.reached).subspan(begin);
}

/// Sets the front to the next pairs of the flood at t = 0; without any, that flood has ended.
void continue_at_start(BoundaryFloodState& state, std::span<const ElementPair> fresh, Executor& executor) {
  detail::FloodFront front(*state.step, state.stars.table(), state.outer.table(), state.seen_at_start, state.front);
  state.front.clear();
  if (state.phase == Phase::parts) {
    state.seeds = fresh.size();
    propose_from_start(state, fresh, front, executor);
  } else {
    for (const ElementPair pair : fresh) front.propose_neighbours_at_start(pair, state.start_scratch);
  }
  state.phase = Phase::at_start;
}

/// Sets the front to the next pairs of the flood over the whole step; without any, that flood has ended.
void continue_flood(BoundaryFloodState& state, std::span<const ElementPair> fresh) {
  detail::FloodFront front(*state.step, state.stars.table(), state.outer.table(), state.seen, state.front);
  state.front.clear();
  if (state.phase == Phase::at_start) {
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
}

/// A round of the pairs in the front.
Round round_of_front(BoundaryFloodState& state, RoundKind kind) {
  state.counters.examined += state.front.size();
  if (kind == RoundKind::pairs_at_start) state.counters.examined_at_start += state.front.size();
  return {(state.front.size() + kPairs - 1) / kPairs, kind};
}

Round begin_orphans(BoundaryFloodState& state) {
  state.phase = Phase::orphans;
  return {state.orphans.blocks(), RoundKind::tests};
}

/// A round of all pairs of simplices but those that were handed out for the whole step; that of the orphans if the
/// broad phase has none, because a round without blocks would be the last one.
Round begin_everything(BoundaryFloodState& state, Executor& executor) {
  if (state.phase == Phase::at_start)
    for (std::size_t i = 0; i < state.seeds; ++i) state.seen.insert(state.reached[i]);
  state.phase = Phase::everything;
  state.counters.all_paired = true;
  if (!state.simplices_state) state.simplices_state = state.broad_phase->make_state();
  state.broad_phase->prepare(*state.step, *state.simplices_state, executor);
  const std::size_t blocks = state.broad_phase->blocks(*state.step, *state.simplices_state, executor);
  return blocks > 0 ? Round{blocks, RoundKind::pairs} : begin_orphans(state);
}

/// Pairs whose outer parts may touch.
void append_parts(BoundaryFloodState& state, unsigned worker, std::size_t block, Work& out) {
  Work& found = state.workers[worker].work;
  found.pairs.clear();
  state.broad_phase->run(*state.parts_step, *state.parts_state, worker, block, found);
  const detail::PartTable& table = state.outer.table();
  for (const ElementPair parts : found.pairs) out.pairs.push_back(table.simplices(parts));
}

void append_everything(BoundaryFloodState& state, unsigned worker, std::size_t block, Work& out) {
  Work& found = state.workers[worker].work;
  found.pairs.clear();
  state.broad_phase->run(*state.step, *state.simplices_state, worker, block, found);
  std::copy_if(found.pairs.begin(), found.pairs.end(), std::back_inserter(out.pairs),
               [&](ElementPair pair) { return !state.seen.contains(pair); });
}

void append_orphans(const BoundaryFloodState& state, std::size_t block, TestBatch& out) {
  const std::size_t vf_begin = out.vf.size(), ee_begin = out.ee.size();
  state.orphans.append(block, out);
  state.complex.to_mesh_features(out, vf_begin, ee_begin);
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
               "pairs examined for each simplex, above which all pairs of simplices are examined in place of a flood")
          .renamed("most_boundary", "max_boundary_fraction")
          .renamed("most_divided", "max_divided_fraction")
          .renamed("most_suspect", "max_suspect_fraction")
          .renamed("most_pairs", "max_pairs");
  return options;
}

std::unique_ptr<StageState> BoundaryFlood::make_state_with(const BroadPhase& broad_phase) const {
  return std::make_unique<BoundaryFloodState>(&broad_phase);
}

void BoundaryFlood::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  BoundaryFloodState& state = own(stage_state);
  state.taken = false;
  state.phase = Phase::parts;
  state.counters = {};
  const bool same_mesh = state.counted.sync(step.topology) == TopologyDelta::Extent::none;
  if (!same_mesh || !std::ranges::equal(state.counted_complete, step.piece.complete)) {
    state.boundary_share = boundary_share(step);
    state.divided_share = divided_share(step);
    state.counted_complete.assign(step.piece.complete.begin(), step.piece.complete.end());
  }
  state.counted.confirm();
  if (state.boundary_share > config_.max_boundary_fraction || state.divided_share > config_.max_divided_fraction)
    return;
  state.complex.update(step.topology, executor);
  const Topology& topology = state.complex.topology();
  // Object ids change along a chain of pairs only where objects share vertices. In that case only the tests are
  // filtered.
  state.filter = topology.objects_share_vertices() ? ObjectFilter() : step.filter;
  Piece piece = step.piece;
  piece.region = {};  // chains lead from all of space into the region of the step
  if (piece.cut_stars) {
    state.cut_stars.update(*step.piece.cut_stars, executor);
    piece.cut_stars = &state.cut_stars.topology();
  }
  state.step.emplace(Step{.topology = topology,
                          .motion = step.motion,
                          .filter = state.filter,
                          .separation = step.separation,
                          .t_max = step.t_max,
                          .range = PairRange::nonadjacent,
                          .piece = piece});
  state.stars.update(*state.step, executor);
  state.counters.simplices = topology.mesh().element_count();
  state.counters.suspect_vertices = state.stars.suspects().size();
  if (!detail::few_suspects(step, state.stars.suspects(), config_.max_suspect_fraction)) return;
  state.suspects.update(*state.step, state.stars, executor, [](Index, Index) { return true; });
  state.orphans.update(topology, state.suspects.pairs(), executor);
  state.outer.update(*state.step, state.stars, executor);
  state.counters.paired = state.outer.table().size();
  state.parts_step.emplace(Step{.topology = state.outer.table().topology(),
                                .motion = step.motion,
                                .filter = state.filter,
                                .separation = step.separation,
                                .t_max = step.t_max,
                                .range = PairRange::nonadjacent,
                                .adjacency_table = &state.outer.table().adjacency()});
  if (!state.parts_state) state.parts_state = state.broad_phase->make_state();
  state.broad_phase->prepare(*state.parts_step, *state.parts_state, executor);
  state.workers.resize(executor.workers());
  for (Worker& worker : state.workers) worker.survived.clear();
  state.reached.clear();
  state.seen.clear();
  state.seen_at_start.clear();
  state.taken = true;
}

bool BoundaryFlood::takes(const StageState& state, bool overlaps) const {
  return own(state).taken && (!overlaps || own(state).complex.is_mesh());
}

const Step& BoundaryFlood::step(const StageState& state) const { return *own(state).step; }

void BoundaryFlood::record_survivors(StageState& state, unsigned worker, std::span<const ElementPair> pairs) const {
  std::vector<ElementPair>& survived = own(state).workers[worker].survived;
  survived.insert(survived.end(), pairs.begin(), pairs.end());
}

Round BoundaryFlood::next_round(const Step&, StageState& stage_state, std::size_t number, Executor& executor) const {
  BoundaryFloodState& state = own(stage_state);
  if (number == 0) {
    const std::size_t blocks = state.broad_phase->blocks(*state.parts_step, *state.parts_state, executor);
    if (blocks > 0) return {blocks, RoundKind::pairs};
  }
  if (state.phase == Phase::orphans) return {};
  const std::span<const ElementPair> fresh = collect_survivors(state);
  if (state.phase == Phase::everything) return begin_orphans(state);
  const double limit = config_.max_pairs * static_cast<double>(state.counters.simplices);
  const auto too_many = [&] { return static_cast<double>(state.counters.examined) > limit; };
  if (state.phase != Phase::flood) {
    if (too_many()) return begin_everything(state, executor);
    continue_at_start(state, fresh, executor);
    if (!state.front.empty()) return round_of_front(state, RoundKind::pairs_at_start);
  }
  if (too_many()) return begin_everything(state, executor);
  continue_flood(state, fresh);
  return state.front.empty() ? begin_orphans(state) : round_of_front(state, RoundKind::pairs);
}

void BoundaryFlood::run(const Step&, StageState& stage_state, unsigned worker, std::size_t block, Work& out) const {
  BoundaryFloodState& state = own(stage_state);
  switch (state.phase) {
    case Phase::parts: return append_parts(state, worker, block, out);
    case Phase::everything: return append_everything(state, worker, block, out);
    case Phase::orphans: return append_orphans(state, block, out.tests);
    case Phase::at_start:
    case Phase::flood: break;
  }
  const std::size_t begin = block * kPairs, end = std::min(begin + kPairs, state.front.size());
  out.pairs.insert(out.pairs.end(), state.front.begin() + static_cast<std::ptrdiff_t>(begin),
                   state.front.begin() + static_cast<std::ptrdiff_t>(end));
}

void BoundaryFlood::to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                     std::size_t ee_begin) const {
  own(state).complex.to_mesh_features(tests, vf_begin, ee_begin);
}

void BoundaryFlood::append_counters(const StageState& stage_state, std::vector<StageCounter>& out) const {
  const BoundaryFloodState& state = own(stage_state);
  state.broad_phase->append_counters(*state.parts_state, out);
  out.push_back({"outer_parts", static_cast<double>(state.counters.paired)});
  out.push_back({"suspect_vertices", static_cast<double>(state.counters.suspect_vertices)});
  out.push_back({"examined_pairs", static_cast<double>(state.counters.examined)});
}

const BoundaryFlood::Counters& BoundaryFlood::counters(const StageState& state) { return own(state).counters; }

StageDescriptor<Flood> describe_boundary_flood() {
  return describe_stage<Flood, BoundaryFlood>(
      "boundary-flood", "all contacts of volumes, reached from pairs of boundary elements", Guarantee::conservative);
}

}  // namespace volccd
