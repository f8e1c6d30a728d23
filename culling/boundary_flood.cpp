#include <volccd/culling/boundary_flood.hpp>

#include <optional>

#include <volccd/culling/detail/flood_front.hpp>
#include <volccd/culling/detail/o_set_partners.hpp>
#include <volccd/culling/detail/simplex_complex.hpp>

namespace volccd {

namespace {

/// Elements whose orphans are listed at once.
constexpr std::size_t kBlockElements = 16;
/// The subset keeps elements that it need not have until they are more than 1 in kSpare, and kFewSpare.
constexpr std::size_t kSpare = 4, kFewSpare = 64;

enum class Phase { idle, start, flood };

struct alignas(64) Worker {
  std::vector<ElementPair> reached;
  detail::ElementTouch touch;
  std::vector<Index> covering;
};

struct BoundaryFloodState final : StageState {
  detail::SimplexComplex complex;
  detail::StarTable stars;
  detail::StarClasses classes;
  ElementSubset outer;
  ObjectFilter filter;
  std::optional<Step> step;  ///< of the complex
  bool taken = false, parts_valid = false;
  std::vector<Index> parts;
  detail::PairSet seen, seen_at_start;
  std::vector<ElementPair> front, reached;
  std::vector<Index> orphan_elements;
  std::vector<Worker> workers;
  Phase phase = Phase::idle;
  BoundaryFlood::Counters counters;

  std::size_t bytes() const override {
    std::size_t sum = complex.bytes() + stars.bytes() + classes.bytes() + outer.bytes() + seen.bytes() +
                      seen_at_start.bytes() + (front.capacity() + reached.capacity()) * sizeof(ElementPair) +
                      (parts.capacity() + orphan_elements.capacity()) * sizeof(Index);
    for (const Worker& w : workers)
      sum += sizeof w + w.reached.capacity() * sizeof(ElementPair) + w.touch.bytes() + w.covering.capacity() * sizeof(Index);
    return sum;
  }
};

BoundaryFloodState& own(StageState& state) { return static_cast<BoundaryFloodState&>(state); }
const BoundaryFloodState& own(const StageState& state) { return static_cast<const BoundaryFloodState&>(state); }

/// Elements that the broad phase pairs: those on the boundary, in D, and at a vertex that the complex winds around more than
/// once. Others stay in the set for a while: a tree is spared changes back and forth.
void choose_outer(const Step& step, BoundaryFloodState& state) {
  const Mesh& mesh = step.mesh();
  const auto needed = [&](Index o) {
    if (!mesh.is_live(o)) return false;
    if (state.stars.on_boundary(o) || state.classes.degenerate(o)) return true;
    const std::span<const Index> vertices = mesh.vertices(o);
    return std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return state.classes.wound(v); });
  };
  std::size_t needed_count = 0, kept = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    const bool need = needed(o);
    needed_count += need ? 1 : 0;
    kept += need || (mesh.is_live(o) && state.outer.contains(o)) ? 1 : 0;
  }
  const bool keep = kept <= needed_count + needed_count / kSpare + kFewSpare;
  const std::uint64_t version = state.outer.version();
  state.outer.assign(mesh.element_slots(), [&](Index o) {
    return needed(o) || (keep && mesh.is_live(o) && state.outer.contains(o));
  });
  if (state.outer.version() != version) state.parts_valid = false;
}

/// First elements of the orphans that may touch: those with a vertex in a suspect star.
void find_orphan_elements(const Step& step, BoundaryFloodState& state) {
  state.orphan_elements.clear();
  for (const Index v : state.classes.suspects()) {
    const std::span<const Index> star = step.features().vertex_elements(v);
    state.orphan_elements.insert(state.orphan_elements.end(), star.begin(), star.end());
  }
  std::sort(state.orphan_elements.begin(), state.orphan_elements.end());
  state.orphan_elements.erase(std::unique(state.orphan_elements.begin(), state.orphan_elements.end()),
                              state.orphan_elements.end());
}

/// Lists the orphans of which the first feature belongs to an element first.
class Orphans {
 public:
  Orphans(const BoundaryFloodState& state, Worker& worker, TestBatch& out)
      : topology_(state.complex.topology()),
        classes_(state.classes),
        partners_(topology_, worker.touch, worker.covering),
        out_(out) {
    worker.touch.fit(topology_.mesh().vertex_count(), topology_.mesh().element_slots());
  }

  void of_element(Index o) {
    const Features& features = topology_.features();
    for (const Index v : topology_.mesh().vertices(o)) {
      if (features.first_element_of_vertex(v) != o) continue;
      partners_.triangles_of_vertex(false, v, [&](Index f) {
        if (may_touch(features.vertex_elements(v), features.triangle_elements(f))) out_.vf.push_back({v, f});
      });
    }
    for (const Index e : features.own_edges(o))
      partners_.edges_of_edge(false, e, [&](Index g) { return e < g; }, [&](Index g) {
        if (may_touch(features.edge_elements(e), features.edge_elements(g))) out_.ee.push_back({e, g});
      });
  }

 private:
  /// Two features touch only if all pairs of elements around them have no common vertex of a clear star.
  bool may_touch(std::span<const Index> inc_a, std::span<const Index> inc_b) const {
    for (const Index a : inc_a)
      for (const Index b : inc_b)
        for (const Index v : topology_.mesh().vertices(a)) {
          if (classes_.suspect(v)) continue;
          const std::span<const Index> of_b = topology_.mesh().vertices(b);
          if (std::find(of_b.begin(), of_b.end(), v) != of_b.end()) return false;
        }
    return true;
  }

  const Topology& topology_;
  const detail::StarClasses& classes_;
  detail::OSetPartners partners_;
  TestBatch& out_;
};

}  // namespace

const Options<BoundaryFlood::Config>& BoundaryFlood::options() {
  static const Options<Config> options =
      Options<Config>().add("most_degenerate", &Config::most_degenerate, 0, 1,
                            "share of simplices not proven to keep their orientation above which a step is not flooded");
  return options;
}

std::unique_ptr<StageState> BoundaryFlood::make_state() const { return std::make_unique<BoundaryFloodState>(); }

void BoundaryFlood::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  BoundaryFloodState& state = own(stage_state);
  state.taken = false;
  state.phase = Phase::idle;
  state.counters = {};
  if (step.separation > 0) return;
  state.complex.update(step.topology);
  const Topology& topology = state.complex.topology();
  // Object ids change along a chain of pairs only where objects share vertices; there the tests alone are filtered.
  state.filter = topology.objects_share_vertices() ? ObjectFilter() : step.filter;
  state.step.emplace(Step{topology, step.motion, state.filter, 0, step.t_max, &state.outer});
  const TopologyDelta::Extent changed = state.stars.update(topology);
  if (changed != TopologyDelta::Extent::none) state.parts_valid = false;
  state.classes.update(*state.step, state.stars, changed, executor);
  state.counters.simplices = topology.mesh().element_count();
  state.counters.degenerate = state.classes.degenerate_count();
  state.counters.suspect_vertices = state.classes.suspects().size();
  if (static_cast<double>(state.counters.degenerate) >
      config_.most_degenerate * static_cast<double>(state.counters.simplices))
    return;
  choose_outer(*state.step, state);
  state.counters.paired = state.outer.size();
  find_orphan_elements(*state.step, state);
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

Flood::Front BoundaryFlood::next(StageState& stage_state, Executor&) const {
  BoundaryFloodState& state = own(stage_state);
  const Step& step = *state.step;
  state.front.clear();
  const std::size_t begin = state.reached.size();
  for (Worker& worker : state.workers) {
    state.reached.insert(state.reached.end(), worker.reached.begin(), worker.reached.end());
    worker.reached.clear();
  }
  const std::span<const ElementPair> fresh = std::span(state.reached).subspan(begin);
  if (state.phase != Phase::flood) {
    detail::FloodFront at_start(step, state.stars, state.classes, state.seen_at_start, state.front);
    if (state.phase == Phase::idle) {
      if (!state.parts_valid) state.parts = detail::FloodFront::one_of_each_part(step);
      state.parts_valid = true;
      at_start.from_start(state.parts);
    } else {
      for (const ElementPair pair : fresh) {
        state.seen.insert(pair);
        at_start.around_at_start(pair);
      }
    }
    state.phase = Phase::start;
    state.counters.looked_at_start += state.front.size();
    if (!state.front.empty()) {
      state.counters.looked_at += state.front.size();
      return {state.front, true};
    }
  }
  detail::FloodFront front(step, state.stars, state.classes, state.seen, state.front);
  if (state.phase == Phase::start) front.around_suspect_stars();
  for (const ElementPair pair : state.phase == Phase::start ? std::span<const ElementPair>(state.reached) : fresh)
    front.around(pair);
  state.phase = Phase::flood;
  state.counters.looked_at += state.front.size();
  return {state.front, false};
}

void BoundaryFlood::to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                     std::size_t ee_begin) const {
  own(state).complex.to_mesh_features(tests, vf_begin, ee_begin);
}

std::size_t BoundaryFlood::orphan_blocks(const StageState& state) const {
  return (own(state).orphan_elements.size() + kBlockElements - 1) / kBlockElements;
}

void BoundaryFlood::orphans(StageState& stage_state, unsigned worker, std::size_t block, TestBatch& out) const {
  BoundaryFloodState& state = own(stage_state);
  const std::size_t vf_begin = out.vf.size(), ee_begin = out.ee.size();
  Orphans orphans(state, state.workers[worker], out);
  const std::size_t end = std::min(state.orphan_elements.size(), (block + 1) * kBlockElements);
  for (std::size_t i = block * kBlockElements; i < end; ++i) orphans.of_element(state.orphan_elements[i]);
  state.complex.to_mesh_features(out, vf_begin, ee_begin);
}

const BoundaryFlood::Counters& BoundaryFlood::counters(const StageState& state) { return own(state).counters; }

StageDescriptor<Flood> describe_boundary_flood() {
  return describe_stage<Flood, BoundaryFlood>(
      "boundary-flood", "all contacts of volumes, reached from pairs of boundary elements", Guarantee::conservative);
}

}  // namespace volccd
