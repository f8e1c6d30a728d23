#include <volccd/broadphase/brute_force.hpp>

#include <numeric>
#include <vector>

#include <volccd/broadphase/detail/box_rows.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/core/heap_bytes.hpp>

namespace volccd {

namespace {

constexpr std::size_t kRowGrain = 16;

struct BruteForceState final : StageState {
  ElementDelta delta;
  detail::FilterKeys keys;
  detail::ElementList list;
  detail::BoxRows boxes;
  detail::PairWriters writers;
  std::vector<std::vector<Index>> hits;  ///< one list for each worker

  std::size_t bytes() const override { return heap_bytes(delta, keys, list, boxes, writers, hits); }
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
  const bool changed = state.delta.sync(step) != ElementDelta::Extent::none;
  if (changed) state.list.assign(step, executor);
  state.keys.update(step, changed);
  if (config_.bounds == Bounds::aabb) state.boxes.update(step, state.list, executor);
  state.delta.confirm();
}

void BruteForce::run(const Step& step, StageState& stage_state, PairRange range, Executor& executor,
                     PairSink sink) const {
  BruteForceState& state = static_cast<BruteForceState&>(stage_state);
  const detail::PairRules rules(range, step.topology, state.keys);
  const std::size_t count = state.list.size();
  const Index* const slots = state.list.slots();
  state.writers.start(executor.workers(), sink);
  state.hits.resize(executor.workers());
  for (std::vector<Index>& hits : state.hits) hits.resize(count + detail::BoxRows::kPadding);

  executor.parallel_for(count, kRowGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    detail::PairWriter& out = state.writers[w];
    Index* const hits = state.hits[w].data();
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = rules.self_pairs ? i : i + 1;
      std::size_t found = count - first;
      if (config_.bounds == Bounds::aabb)
        found = state.boxes.overlapping(i, first, count, hits);
      else
        std::iota(hits, hits + found, static_cast<Index>(first));
      for (std::size_t h = 0; h < found; ++h)
        if (rules.want(slots[i], slots[hits[h]])) out.push(slots[i], slots[hits[h]]);
    }
  });
  state.writers.finish();
}

StageDescriptor<BroadPhase> describe_brute_force() {
  return describe_stage<BroadPhase, BruteForce>("brute-force", "every pair of elements, by swept boxes or not at all",
                                                Guarantee::conservative);
}

}  // namespace volccd
