#include <volccd/peers/detail/peer_phase.hpp>

#include <algorithm>
#include <cmath>

namespace volccd::detail {

namespace {

constexpr int kBoxes = 6;
constexpr std::size_t kBlock = 4096;  ///< pairs, or self pairs, of a block

}  // namespace

std::size_t PeerState::bytes() const {
  return heap_bytes(delta, keys, slots, vertices, boxes, pairs, chunks) + peer_bytes();
}

void PeerState::set_scale() {
  float reach = 0;
  for (std::size_t p = 0; p < slots.size(); ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      reach = std::max({reach, std::abs(low(p)[axis]), std::abs(high(p)[axis])});
  scale = reach > 1e12f ? 0x1p-90f : 1;
}

void PeerPhase::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  PeerState& state = static_cast<PeerState&>(stage_state);
  const bool changed = state.delta.sync(step.topology) != TopologyDelta::Extent::none;
  if (changed) list_elements(step.mesh(), state.slots);
  state.keys.update(step, changed);
  state.bounds_seconds = bound_vertices(step, kBoxes, executor, state.vertices);
  bound_elements(state.vertices, {state.slots, step.topology.adjacency()}, executor, state.boxes);
  update(state, changed, executor);
  state.delta.confirm();
}

std::size_t PeerPhase::blocks(const Step& step, StageState& stage_state, Executor& executor) const {
  PeerState& state = static_cast<PeerState&>(stage_state);
  const PairRules rules(step, state.keys);
  state.rules = &rules;
  state.pairs.resize(executor.workers());
  for (std::vector<ElementPair>& pairs : state.pairs) pairs.clear();
  if (state.slots.size() > 1) collide(state, executor);
  state.rules = nullptr;
  state.chunks.clear();
  for (std::size_t w = 0; w < state.pairs.size(); ++w)
    for (std::size_t begin = 0; begin < state.pairs[w].size(); begin += kBlock) state.chunks.push_back({w, begin});
  return state.chunks.size() + (rules.self_pairs ? (state.slots.size() + kBlock - 1) / kBlock : 0);
}

void PeerPhase::run(const Step& step, StageState& stage_state, unsigned, std::size_t block, Work& work) const {
  const PeerState& state = static_cast<const PeerState&>(stage_state);
  if (block < state.chunks.size()) {
    const auto [w, begin] = state.chunks[block];
    const auto first = state.pairs[w].begin() + static_cast<std::ptrdiff_t>(begin);
    work.pairs.insert(
        work.pairs.end(), first,
        first + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(kBlock), state.pairs[w].end() - first));
    return;
  }
  const std::size_t begin = (block - state.chunks.size()) * kBlock;
  PairWriter out(work);
  write_self_pairs(state.slots, PairRules(step, state.keys), begin, begin + kBlock, out);
  out.flush();
}

void PeerPhase::append_counters(const StageState& state, std::vector<StageCounter>& out) const {
  out.push_back({"bounds_seconds", static_cast<const PeerState&>(state).bounds_seconds});
}

}  // namespace volccd::detail
