#include <volccd/culling/stars/star_orphans.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/o_set/o_set.hpp>
#include <volccd/culling/stars/suspect_orphans.hpp>
#include <volccd/culling/stars/suspect_pairs.hpp>
#include <volccd/culling/stars/suspect_share.hpp>
#include <volccd/culling/stars/vertex_stars.hpp>
#include <volccd/mesh/shells.hpp>

namespace volccd {

namespace {

constexpr std::size_t kCountedElements = 1024;

/// Pairs of elements with a common edge are tested for a plane if the product of their numbers of edges that no other
/// element has is at least this. Other pairs, those of sheets above all, have few orphans, whose tests take less time.
constexpr int kMinFreeEdges = 10;

struct StarOrphansState final : StageState {
  OSet set;
  detail::VertexStars stars;
  TopologyDelta counted;                  ///< the topology for which the following was determined
  bool without_shell_neighbours = false;  ///< Step::leave_out_shell_neighbours, for which it was
  bool volumes = false;
  std::vector<std::uint8_t> free_edges;  ///< by element slot: edges that no other element has, up to 255
  detail::SuspectPairs pairs;            ///< those of which the orphans are listed
  detail::SuspectOrphans orphans;
  StarOrphans::Counters counters;

  std::size_t bytes() const override { return heap_bytes(set, stars, counted, free_edges, pairs, orphans); }
};

StarOrphansState& state_of(StageState& state) { return static_cast<StarOrphansState&>(state); }
const StarOrphansState& state_of(const StageState& state) { return static_cast<const StarOrphansState&>(state); }

/// Whether each vertex of an element has a copy of its shell vertex in the element, as in a thickened shell.
bool is_thickened(std::span<const Index> vertices) {
  return std::ranges::all_of(vertices, [&](Index v) {
    return std::ranges::any_of(vertices, [&](Index w) { return w != v && shell_vertex(w) == shell_vertex(v); });
  });
}

/// Whether there are elements with so many orphans that the classification of stars pays: not of shells, also
/// thickened ones if their neighbours are left out.
bool has_volumes(const Mesh& mesh, bool without_shell_neighbours) {
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && !is_shell(mesh.type(o)) && !(without_shell_neighbours && is_thickened(mesh.vertices(o))))
      return true;
  return false;
}

std::uint8_t count_free_edges(const Features& features, Index o) {
  const std::span<const Index> edges = features.own_edges(o);
  const auto is_free = [&](Index e) { return features.edge_elements(e).size() == 1; };
  return static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(std::count_if(edges.begin(), edges.end(), is_free), 255));
}

/// Determines what depends on the topology: after edits, for the elements at vertices whose elements changed.
void count_elements(const Step& step, StarOrphansState& state, Executor& executor) {
  const Topology& topology = step.topology;
  const bool other =
      std::exchange(state.without_shell_neighbours, step.leave_out_shell_neighbours) != step.leave_out_shell_neighbours;
  const TopologyDelta::Extent changed = state.counted.sync(topology);
  if (changed == TopologyDelta::Extent::none && !other) return;
  state.volumes = has_volumes(topology.mesh(), step.leave_out_shell_neighbours);
  const bool all = changed == TopologyDelta::Extent::everything || other || state.free_edges.empty();
  state.free_edges.resize(state.volumes ? topology.mesh().element_slots() : 0);  // surfaces have no use for it
  const auto count = [&](Index o) { state.free_edges[o] = count_free_edges(topology.features(), o); };
  if (all) {
    executor.parallel_for(state.free_edges.size(), kCountedElements, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t o = begin; o < end; ++o) count(static_cast<Index>(o));
    });
  } else if (state.volumes) {
    for (const Index o : state.counted.changed_slots()) count(o);
    for (const TopologyChange* change : state.counted.changes())
      for (const Index v : change->features.touched_vertices)
        for (const Index o : topology.features().vertex_elements(v)) count(o);
  }
  state.counted.confirm();
}

void list_pairs(const Step& step, StarOrphansState& state, Executor& executor) {
  state.pairs.update(step, state.stars, executor,
                     [&](Index a, Index b) { return state.free_edges[a] * state.free_edges[b] >= kMinFreeEdges; });
  state.counters.pairs = state.pairs.pairs().size();
  state.orphans.update(step.topology, state.pairs.pairs(), executor, step.leave_out_shell_neighbours);
}

}  // namespace

const Options<StarOrphans::Config>& StarOrphans::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("max_suspect_fraction", &Config::max_suspect_fraction, 0, 1,
               "share of vertices whose stars may fold above which the O-Set provides the orphans")
          .renamed("most_suspect", "max_suspect_fraction");
  return options;
}

std::unique_ptr<StageState> StarOrphans::make_state() const { return std::make_unique<StarOrphansState>(); }

void StarOrphans::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  StarOrphansState& state = state_of(stage_state);
  state.counters = {};
  count_elements(step, state, executor);
  if (state.volumes) {
    Step alone = step;  // in a region, few pairs at a cut have orphans: less work than the other elements at the cut
    alone.piece.cut_stars = nullptr;
    state.stars.update(alone, executor);
    state.counters.suspect_vertices = state.stars.suspects().size();
    state.counters.by_stars = detail::few_suspects(step, state.stars.suspects(), config_.max_suspect_fraction);
  }
  if (!state.counters.by_stars) return state.set.update(step.topology, executor, step.leave_out_shell_neighbours);
  list_pairs(step, state, executor);
}

std::size_t StarOrphans::blocks(const StageState& stage_state) const {
  const StarOrphansState& state = state_of(stage_state);
  return state.counters.by_stars ? state.orphans.blocks() : state.set.blocks();
}

void StarOrphans::run(const Step&, StageState& stage_state, unsigned, std::size_t block, Work& out) const {
  const StarOrphansState& state = state_of(stage_state);
  if (!state.counters.by_stars) return state.set.append(block, out.tests);
  state.orphans.append(block, out.tests);
}

const StarOrphans::Counters& StarOrphans::counters(const StageState& state) { return state_of(state).counters; }

StageDescriptor<OrphanSource> describe_star_orphans() {
  return describe_stage<OrphanSource, StarOrphans>(
      "star-orphans", "the orphans around vertices whose elements may fold, in place of the O-Set",
      Guarantee::conservative);
}

}  // namespace volccd
