#include <volccd/broadphase/spatial_hash.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <volccd/broadphase/detail/kdop_option.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/broadphase/hash/detail/hash_grid.hpp>
#include <volccd/broadphase/hash/detail/hash_kernels.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

namespace {

/// Entries of the grid, and elements, of a block.
constexpr std::size_t kEntries = 4096, kElements = 1024;

struct SpatialHashState final : StageState {
  TopologyDelta delta;
  detail::FilterKeys keys;
  std::vector<Index> slots;  ///< elements in the order of their bounds
  double bounds_seconds = 0;
  detail::BoundsTable vertices, elements;
  detail::HashGrid grid;
  std::size_t entry_blocks = 0, large_blocks = 0;
  std::vector<detail::BucketScratch> scratch;

  std::size_t bytes() const override { return heap_bytes(delta, keys, slots, vertices, elements, grid, scratch); }
};

/// Moves the low 21 bits to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Lists the elements in the order of a Morton curve through their first vertices, so that elements that share cells
/// are close in memory. The order affects only speed; therefore it is not updated afterwards.
void list_in_space(const Step& step, std::vector<Index>& slots) {
  detail::list_elements(step.mesh(), slots);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  for (Index v = 0; v < step.motion.vertex_count(); ++v) {
    low = low.cwiseMin(step.motion.point(v, 0));
    high = high.cwiseMax(step.motion.point(v, 0));
  }
  std::vector<std::pair<std::uint64_t, Index>> codes(slots.size());
  for (std::size_t p = 0; p < slots.size(); ++p) {
    const Vec3 at = step.motion.point(step.mesh().vertices(slots[p])[0], 0);
    std::uint64_t code = 0;
    for (int c = 0; c < 3; ++c) {
      const double part = (at[c] / 2 - low[c] / 2) / (high[c] / 2 - low[c] / 2);  // halved to avoid overflow
      code |= spread(part >= 0 ? static_cast<std::uint64_t>(std::min(part, 1.0) * 0x1fffff) : 0) << c;
    }
    codes[p] = {code, slots[p]};
  }
  std::sort(codes.begin(), codes.end());
  for (std::size_t p = 0; p < slots.size(); ++p) slots[p] = codes[p].second;
}

}  // namespace

SpatialHash::SpatialHash(const Config& config) : config_(config) {
  detail::check_k(config.k);
  if (!(config.cell_size >= 0.05 && config.cell_size <= 100))
    throw ConfigError("spatial-hash: cell_size must lie in 0.05 .. 100");
}

const Options<SpatialHash::Config>& SpatialHash::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("k", &Config::k, detail::k_choices(), "directions of the k-DOPs of the final test, 6 being boxes")
          .add("cell_size", &Config::cell_size, 0.05, 100, "side of a cell, in median extents of the swept boxes");
  return options;
}

std::unique_ptr<StageState> SpatialHash::make_state() const { return std::make_unique<SpatialHashState>(); }

void SpatialHash::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  SpatialHashState& state = static_cast<SpatialHashState&>(stage_state);
  const TopologyDelta::Extent changed = state.delta.sync(step.topology);
  if (changed == TopologyDelta::Extent::everything)
    list_in_space(step, state.slots);
  else if (changed == TopologyDelta::Extent::edits)
    detail::update_elements(step.mesh(), state.delta.changed_slots(), state.slots);
  state.keys.update(step, changed != TopologyDelta::Extent::none);
  state.bounds_seconds = detail::bound_vertices(step, config_.k, executor, state.vertices);
  detail::bound_elements(state.vertices, {state.slots, step.topology.adjacency()}, executor, state.elements);
  state.grid.build(state.elements, state.slots.size(), config_.cell_size, kMaxCells, executor);
  state.delta.confirm();
}

std::size_t SpatialHash::blocks(const Step& step, StageState& stage_state, Executor& executor) const {
  SpatialHashState& state = static_cast<SpatialHashState&>(stage_state);
  state.scratch.resize(executor.workers());
  for (detail::BucketScratch& scratch : state.scratch) scratch.reserve(state.grid.largest_bucket());
  const auto blocks_of = [](std::size_t count, std::size_t size) { return (count + size - 1) / size; };
  state.entry_blocks = blocks_of(state.grid.entries().size(), kEntries);
  state.large_blocks = state.grid.large().empty() ? 0 : blocks_of(state.slots.size(), kElements);
  const bool self_pairs = step.range == PairRange::every;
  return state.entry_blocks + state.large_blocks + (self_pairs ? blocks_of(state.slots.size(), kElements) : 0);
}

void SpatialHash::run(const Step& step, StageState& stage_state, unsigned worker, std::size_t block, Work& work) const {
  SpatialHashState& state = static_cast<SpatialHashState&>(stage_state);
  const detail::PairRules rules(step, state.keys);
  detail::PairWriter out(work);
  if (block < state.entry_blocks) {
    const std::size_t begin = block * kEntries, end = std::min(begin + kEntries, state.grid.entries().size());
    detail::hash_entries(state.grid, state.elements, state.slots.data(), rules, begin, end, state.scratch[worker], out);
  } else {
    block -= state.entry_blocks;
    const bool large = block < state.large_blocks;
    const std::size_t begin = (large ? block : block - state.large_blocks) * kElements;
    const std::size_t end = std::min(begin + kElements, state.slots.size());
    if (large)
      detail::hash_large(state.grid, state.elements, state.slots.data(), rules, begin, end, out);
    else
      detail::write_self_pairs(state.slots, rules, begin, end, out);
  }
  out.flush();
}

void SpatialHash::append_counters(const StageState& state, std::vector<StageCounter>& out) const {
  out.push_back({"bounds_seconds", static_cast<const SpatialHashState&>(state).bounds_seconds});
}

StageDescriptor<BroadPhase> describe_spatial_hash() {
  return describe_stage<BroadPhase, SpatialHash>(
      "spatial-hash", "uniform grid, hashed (Teschner et al. 2003), over swept boxes", Guarantee::conservative);
}

}  // namespace volccd
