#include <volccd/broadphase/kdop_bvh.hpp>

#include <algorithm>
#include <vector>

#include <volccd/broadphase/bvh/detail/kdop_tree.hpp>
#include <volccd/broadphase/bvh/detail/tree_kernels.hpp>
#include <volccd/broadphase/detail/kdop_option.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

namespace {

using detail::NodePair;

/// Number of node pairs at which expansion stops; the workers share these pairs. The last expansion at most quadruples
/// the number.
constexpr std::size_t kTasks = 1024;
/// Node pairs of a block: so many that the cost of a block is negligible.
constexpr std::size_t kTasksOfBlock = 8;

struct alignas(64) Worker {
  std::vector<NodePair> stack;
  std::uint64_t node_tests = 0;  ///< of all steps
  std::size_t bytes() const { return heap_bytes(stack); }
};

struct KdopBvhState final : StageState {
  TopologyDelta delta;
  detail::FilterKeys keys;
  double bounds_seconds = 0;
  detail::BoundsTable vertices;
  detail::KdopTree tree;
  std::vector<NodePair> tasks, expanded;
  std::vector<Worker> workers;
  KdopBvh::Counters counters;

  std::size_t bytes() const override { return heap_bytes(delta, keys, vertices, tree, tasks, expanded, workers); }
};

/// Computes the list of node pairs at which a query starts, which is deterministic, into state.tasks. Returns the
/// number of node tests.
std::uint64_t make_tasks(KdopBvhState& state, const detail::PairRules& rules) {
  state.tasks.clear();
  state.tasks.reserve(4 * kTasks);
  state.expanded.reserve(4 * kTasks);
  const std::vector<Index>& roots = state.tree.roots();
  for (std::size_t i = 0; i < roots.size(); ++i)
    for (std::size_t j = i; j < roots.size(); ++j)
      if (rules.may_include(state.tree.nodes()[roots[i]].key, state.tree.nodes()[roots[j]].key))
        state.tasks.push_back({roots[i], roots[j]});
  std::uint64_t tests = 0;
  for (bool grows = true; grows && state.tasks.size() < kTasks;) {
    state.expanded.clear();
    const std::uint64_t more = detail::expand_pairs(state.tree, rules, state.tasks, state.expanded);
    state.tasks.swap(state.expanded);
    tests += more;
    grows = more > 0;
  }
  return tests;
}

}  // namespace

KdopBvh::KdopBvh(const Config& config) : config_(config) {
  detail::check_k(config.k);
  if (config.leaf_size < 1 || config.leaf_size > detail::KdopTree::kMaxLeafSize)
    throw ConfigError("kdop-bvh: leaf_size must lie in 1 .. 8");
  if (!(config.degradation >= 1)) throw ConfigError("kdop-bvh: degradation must be at least 1");
}

const Options<KdopBvh::Config>& KdopBvh::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("k", &Config::k, detail::k_choices(), "directions of the k-DOPs, 6 being boxes")
          .add("leaf_size", &Config::leaf_size, 1, detail::KdopTree::kMaxLeafSize, "elements a leaf")
          .add("adjacent_pairs", &Config::adjacent_pairs,
               {{"table", AdjacentPairs::table}, {"vertices", AdjacentPairs::vertices}},
               "found in a table that is kept from step to step, or by their vertices")
          .add("restructure", &Config::restructure,
               {{"none", Restructure::none}, {"subtrees", Restructure::subtrees}, {"always", Restructure::always}},
               "rebuild nothing, the subtrees that degraded, or all at every step")
          .add("degradation", &Config::degradation, 1, 1e9,
               "tolerated growth of a subtree's cost before it is rebuilt");
  return options;
}

std::unique_ptr<StageState> KdopBvh::make_state() const { return std::make_unique<KdopBvhState>(); }

void KdopBvh::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  KdopBvhState& state = static_cast<KdopBvhState&>(stage_state);
  state.bounds_seconds = detail::bound_vertices(step, config_.k, executor, state.vertices);
  const TopologyDelta::Extent changed = state.delta.sync(step.topology);
  bool build = changed == TopologyDelta::Extent::everything || config_.restructure == Restructure::always;
  if (!build && changed == TopologyDelta::Extent::edits)
    build = !state.tree.edit(step, state.delta.changed_slots(), state.vertices, executor);
  std::size_t restructured = 0;
  if (build) {
    state.tree.build(step, config_.leaf_size, state.vertices, executor);
    ++state.counters.builds;
    if (config_.restructure != Restructure::always) state.tree.free_scratch();
  } else {
    state.tree.refit(step, state.vertices, executor);
    if (config_.restructure == Restructure::subtrees)
      restructured = state.tree.restructure(step, config_.degradation, state.vertices, executor);
    state.counters.restructured_elements += restructured;
  }
  const bool new_elements = build || changed != TopologyDelta::Extent::none;
  const bool new_keys = state.keys.update(step, new_elements);
  if (!state.keys.trivial() && (new_elements || restructured > 0 || new_keys)) state.tree.set_keys(state.keys);
  state.delta.confirm();
}

std::size_t KdopBvh::blocks(const Step& step, StageState& stage_state, Executor& executor) const {
  KdopBvhState& state = static_cast<KdopBvhState&>(stage_state);
  const detail::PairRules rules(step, state.keys);
  if (rules.adjacency && config_.adjacent_pairs == AdjacentPairs::table && config_.restructure != Restructure::always)
    state.tree.find_adjacent_leaves(step, executor);
  state.counters.node_tests += make_tasks(state, rules);
  state.workers.resize(std::max<std::size_t>(state.workers.size(), executor.workers()));
  for (Worker& worker : state.workers)
    worker.stack.resize(std::max(worker.stack.size(), detail::stack_length(state.tree)));
  return (state.tasks.size() + kTasksOfBlock - 1) / kTasksOfBlock;
}

void KdopBvh::run(const Step& step, StageState& stage_state, unsigned w, std::size_t block, Work& work) const {
  KdopBvhState& state = static_cast<KdopBvhState&>(stage_state);
  Worker& worker = state.workers[w];
  detail::PairWriter out(work);
  const detail::PairRules rules(step, state.keys);
  const std::size_t end = std::min(state.tasks.size(), (block + 1) * kTasksOfBlock);
  for (std::size_t i = block * kTasksOfBlock; i < end; ++i)
    worker.node_tests += detail::traverse(state.tree, rules, state.tasks[i], worker.stack.data(), out);
  out.flush();
}

KdopBvh::Counters KdopBvh::counters(const StageState& stage_state) {
  const KdopBvhState& state = static_cast<const KdopBvhState&>(stage_state);
  Counters counters = state.counters;
  for (const Worker& worker : state.workers) counters.node_tests += worker.node_tests;
  return counters;
}

void KdopBvh::append_counters(const StageState& state, std::vector<StageCounter>& out) const {
  out.push_back({"bounds_seconds", static_cast<const KdopBvhState&>(state).bounds_seconds});
}

StageDescriptor<BroadPhase> describe_kdop_bvh() {
  return describe_stage<BroadPhase, KdopBvh>(
      "kdop-bvh", "bounding volume hierarchy of swept k-DOPs, refitted each step", Guarantee::conservative);
}

}  // namespace volccd
