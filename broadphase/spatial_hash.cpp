#include <volccd/broadphase/spatial_hash.hpp>

#include <vector>

#include <volccd/broadphase/detail/hash_grid.hpp>
#include <volccd/broadphase/detail/hash_kernels.hpp>
#include <volccd/broadphase/detail/kdop_option.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/mesh/topology_watch.hpp>

namespace volccd {

namespace {

constexpr std::size_t kEntryGrain = 4096, kLargeGrain = 1024;

struct State final : StageState {
  TopologyWatch watch;
  detail::FilterKeys keys;
  detail::ElementList list;
  detail::BoundsTable vertices, elements;
  detail::HashGrid grid;
  detail::PairWriters writers;
  std::vector<detail::BucketScratch> scratch;

  std::size_t bytes() const override {
    std::size_t sum = watch.bytes() + keys.bytes() + list.bytes() + vertices.bytes() + elements.bytes() + grid.bytes() +
                      writers.bytes();
    for (const detail::BucketScratch& s : scratch) sum += sizeof s + s.bytes();
    return sum;
  }
};

}  // namespace

SpatialHash::SpatialHash(const Config& config) : config_(config) {
  detail::check_k(config.k);
  if (!(config.cell_size >= 0.05 && config.cell_size <= 100))
    throw ConfigError("spatial-hash: cell_size must lie in 0.05 .. 100");
}

const Options<SpatialHash::Config>& SpatialHash::options() {
  static const Options<Config> options = [] {
    Options<Config> o;
    o.add("k", &Config::k, detail::k_choices(), "directions of the k-DOPs of the final test, 6 being boxes");
    o.add("cell_size", &Config::cell_size, 0.05, 100, "side of a cell, in median extents of the swept boxes");
    return o;
  }();
  return options;
}

std::unique_ptr<StageState> SpatialHash::make_state() const { return std::make_unique<State>(); }

void SpatialHash::update(const Step& step, StageState& stage_state, Executor& executor) const {
  State& state = static_cast<State&>(stage_state);
  const bool news = state.watch.look(step.topology) != TopologyWatch::News::none;
  if (news) state.list.assign_live(step.mesh());
  state.keys.update(step, news);
  detail::bound_vertices(step, config_.k, executor, state.vertices);
  state.elements.resize(state.list.size(), state.vertices.width());
  detail::bound_elements(state.vertices, state.list, executor, state.elements);
  state.grid.build(state.elements, state.list.size(), config_.cell_size, kMostCells, executor);
}

void SpatialHash::query(const Step&, StageState& stage_state, PairRange range, Executor& executor,
                        PairSink sink) const {
  State& state = static_cast<State&>(stage_state);
  const detail::PairRules rules(range, state.watch.adjacency(), state.keys);
  state.writers.start(executor.workers(), sink);
  state.scratch.resize(executor.workers());
  for (detail::BucketScratch& scratch : state.scratch) scratch.reserve(state.grid.largest_bucket());

  const Index* const slots = state.list.slots();
  executor.parallel_for(
      state.grid.entries().size(), kEntryGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
        detail::hash_entries(state.grid, state.elements, slots, rules, begin, end, state.scratch[w], state.writers[w]);
      });
  if (!state.grid.large().empty())
    executor.parallel_for(state.list.size(), kLargeGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
      detail::hash_large(state.grid, state.elements, slots, rules, begin, end, state.writers[w]);
    });
  if (rules.self_pairs)
    for (std::size_t p = 0; p < state.list.size(); ++p)
      if (rules.want(slots[p], slots[p])) state.writers[0].push(slots[p], slots[p]);
  state.writers.finish();
}

StageDescriptor<BroadPhase> describe_spatial_hash() {
  return describe_stage<BroadPhase, SpatialHash>(
      "spatial-hash", "uniform grid, hashed (Teschner et al. 2003), over swept boxes", Guarantee::conservative);
}

}  // namespace volccd
