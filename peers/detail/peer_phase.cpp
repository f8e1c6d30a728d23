#include <volccd/peers/detail/peer_phase.hpp>

#include <algorithm>
#include <cmath>

namespace volccd::detail {

namespace {

constexpr int kBoxes = 6;

}  // namespace

std::size_t PeerState::bytes() const { return heap_bytes(delta, keys, list, vertices, boxes, writers) + peer_bytes(); }

void PeerState::set_scale() {
  float reach = 0;
  for (std::size_t p = 0; p < list.size(); ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      reach = std::max({reach, std::abs(low(p)[axis]), std::abs(high(p)[axis])});
  scale = reach > 1e12f ? 0x1p-90f : 1;
}

void PeerPhase::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  PeerState& state = static_cast<PeerState&>(stage_state);
  const bool changed = state.delta.sync(step) != ElementDelta::Extent::none;
  if (changed) state.list.assign(step, executor);
  state.keys.update(step, changed);
  state.bounds_seconds = bound_vertices(step, kBoxes, executor, state.vertices);
  bound_elements(state.vertices, state.list, executor, state.boxes);
  update(state, changed, executor);
  state.delta.confirm();
}

void PeerPhase::run(const Step& step, StageState& stage_state, PairRange range, Executor& executor,
                    PairSink sink) const {
  PeerState& state = static_cast<PeerState&>(stage_state);
  const PairRules rules(range, step.topology, state.keys);
  state.rules = &rules;
  state.writers.start(executor.workers(), sink);
  if (state.list.size() > 1) collide(state, executor);
  write_self_pairs(state.list, rules, executor, state.writers);
  state.writers.finish();
}

double PeerPhase::bounds_seconds(const StageState& state) const {
  return static_cast<const PeerState&>(state).bounds_seconds;
}

}  // namespace volccd::detail
