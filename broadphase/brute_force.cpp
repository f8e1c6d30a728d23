#include <volccd/broadphase/brute_force.hpp>

#include <algorithm>
#include <numeric>
#include <vector>

#include <volccd/broadphase/detail/box_rows.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

namespace {

constexpr std::size_t kRows = 16;  ///< elements of a block

struct BruteForceState final : StageState {
  TopologyDelta delta;
  detail::FilterKeys keys;
  std::vector<Index> slots;  ///< live elements, ascending
  detail::BoxRows boxes;
  std::vector<std::vector<Index>> hits;  ///< one list for each worker

  std::size_t bytes() const override { return heap_bytes(delta, keys, slots, boxes, hits); }
};

}  // namespace

const Options<BruteForce::Config>& BruteForce::options() {
  static const Options<Config> options =
      Options<Config>().add("bounds", &Config::bounds, {{"none", Bounds::none}, {"aabb", Bounds::aabb}},
                            "every pair, or those whose swept boxes overlap");
  return options;
}

std::unique_ptr<StageState> BruteForce::make_state() const { return std::make_unique<BruteForceState>(); }

void BruteForce::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  BruteForceState& state = static_cast<BruteForceState&>(stage_state);
  const bool changed = state.delta.sync(step.topology) != TopologyDelta::Extent::none;
  if (changed) detail::list_elements(step.mesh(), state.slots);
  state.keys.update(step, changed);
  if (config_.bounds == Bounds::aabb) state.boxes.update(step, {state.slots, step.topology.adjacency()}, executor);
  state.delta.confirm();
}

std::size_t BruteForce::blocks(const Step&, StageState& stage_state, Executor& executor) const {
  BruteForceState& state = static_cast<BruteForceState&>(stage_state);
  state.hits.resize(executor.workers());
  for (std::vector<Index>& hits : state.hits) hits.resize(state.slots.size() + detail::BoxRows::kPadding);
  return (state.slots.size() + kRows - 1) / kRows;
}

void BruteForce::run(const Step& step, StageState& stage_state, unsigned worker, std::size_t block, Work& work) const {
  BruteForceState& state = static_cast<BruteForceState&>(stage_state);
  const detail::PairRules rules(step, state.keys);
  const std::size_t count = state.slots.size(), end = std::min(count, (block + 1) * kRows);
  const std::vector<Index>& slots = state.slots;
  Index* const hits = state.hits[worker].data();
  detail::PairWriter out(work);
  for (std::size_t i = block * kRows; i < end; ++i) {
    const std::size_t first = rules.self_pairs ? i : i + 1;
    std::size_t found = count - first;
    if (config_.bounds == Bounds::aabb)
      found = state.boxes.overlapping(i, first, count, hits);
    else
      std::iota(hits, hits + found, static_cast<Index>(first));
    for (std::size_t h = 0; h < found; ++h)
      if (rules.included(slots[i], slots[hits[h]])) out.push(slots[i], slots[hits[h]]);
  }
  out.flush();
}

StageDescriptor<BroadPhase> describe_brute_force() {
  return describe_stage<BroadPhase, BruteForce>("brute-force", "every pair of elements, by swept boxes or not at all",
                                                Guarantee::conservative);
}

}  // namespace volccd
