#include <volccd/broadphase/bvh/detail/tree_builder.hpp>

#include <algorithm>
#include <limits>

#include <volccd/broadphase/detail/filter_keys.hpp>

namespace volccd::detail {

namespace {

/// Ranges with fewer items are split at the median.
constexpr Index kMinBinned = 32;
constexpr std::size_t kBins = BuildBins::kCount;
/// A range that several threads split has at most kMaxChunks chunks, of about kMinChunk items or more.
constexpr Index kMinChunk = 1024, kMaxChunks = 64;

double cost_of(const BuildBins::Bin& bin) { return bin.box.half_area() * static_cast<double>(bin.count); }

void add(BuildBins::Bin& sum, const BuildBins::Bin& bin) {
  sum.box.add(bin.box);
  sum.count += bin.count;
}

struct Split {
  double cost;
  std::size_t axis;
  Index left_leaves;
};

/// Selects the best boundary between bins on this axis, if it is cheaper than the best so far.
void sweep_bins(const std::array<BuildBins::Bin, kBins>& bins, std::size_t axis, Index leaf_size, Split& best) {
  std::array<double, kBins> right_cost{};
  BuildBins::Bin right{BuildBox::empty(), 0}, left = right;
  for (std::size_t b = kBins; b-- > 1;) {
    add(right, bins[b]);
    right_cost[b] = cost_of(right);
  }
  for (std::size_t b = 0; b + 1 < kBins; ++b) {
    add(left, bins[b]);
    const double cost = cost_of(left) + right_cost[b + 1];
    if (cost < best.cost) best = {cost, axis, (left.count + leaf_size / 2) / leaf_size};
  }
}

}  // namespace

int TreeBuilder::build(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree, Index leaf_size,
                       TreeNode* nodes, Executor& executor) {
  const Index count = subtree.end - subtree.begin;
  leaf_size_ = leaf_size;
  offset_ = subtree.begin;
  gather(list, vertices, subtree, executor);
  // Large ranges are split one after the other by all threads, until there are enough for each thread to take some.
  const Index grain = std::max<Index>(2048, count / (8 * executor.workers()));
  tasks_.assign(1, {subtree.node, 0, count, subtree.depth});
  for (std::size_t i = 0; i < tasks_.size();) {
    const Index size = tasks_[i].end - tasks_[i].begin;
    if (size <= grain) {
      ++i;
      continue;
    }
    chunks_.resize(std::clamp<Index>(size / kMinChunk, 1, kMaxChunks));
    const Subtree right = split(tasks_[i], chunks_, nodes, executor);
    tasks_.push_back(right);
  }
  executor.parallel_for(tasks_.size(), 1, [&](std::size_t first, std::size_t last, unsigned) {
    Chunk chunk;
    for (std::size_t i = first; i < last; ++i) tasks_[i].depth = build_range(tasks_[i], chunk, nodes);
  });
  int depth = 0;
  for (const Subtree& task : tasks_) depth = std::max(depth, task.depth);
  return depth;
}

void TreeBuilder::gather(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree,
                         Executor& executor) {
  const std::size_t count = subtree.end - subtree.begin;
  order_.resize(count);
  if (capacity_ < count) {
    for (auto& items : items_) items = std::make_unique_for_overwrite<BuildItem[]>(count);
    capacity_ = count;
  }
  // Gaps take the box of a live element, so that they do not affect the splits or introduce infinities.
  Index live = subtree.begin;
  while (live < subtree.end && list.slot(live) == kNone) ++live;
  BuildItem gap{};
  if (live < subtree.end) make_items(list, vertices, live, live + 1, {}, &gap);
  executor.parallel_for(count, 4096, [&](std::size_t begin, std::size_t end, unsigned) {
    make_items(list, vertices, subtree.begin + static_cast<Index>(begin), subtree.begin + static_cast<Index>(end),
               gap.box, items_[0].get() + begin);
  });
}

/// Returns the depth of the deepest leaf.
int TreeBuilder::build_range(Subtree range, Chunk& chunk, TreeNode* nodes) {
  if (range.end - range.begin <= leaf_size_) {
    nodes[range.node] = {offset_ + range.begin, offset_ + range.end, 0, FilterKeys::kMixed};
    for (Index i = range.begin; i < range.end; ++i) order_[i] = items_[range.side][i].position;
    return range.depth;
  }
  SerialExecutor serial;
  const Subtree right = split(range, {&chunk, 1}, nodes, serial);
  const int depth = build_range(range, chunk, nodes);
  return std::max(depth, build_range(right, chunk, nodes));
}

/// Calls body(chunk, items) for each chunk of a range.
template <class Body>
void TreeBuilder::in_chunks(const Subtree& range, std::span<Chunk> chunks, Executor& executor, Body&& body) {
  const BuildItem* const items = items_[range.side].get() + range.begin;
  const std::size_t count = range.end - range.begin, parts = chunks.size();
  executor.parallel_for(parts, 1, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t begin = count * i / parts, end = count * (i + 1) / parts;
      body(chunks[i], {items + begin, end - begin});
    }
  });
}

/// Makes an inner node of the range, sets `range` to its left half and returns the right half. Both halves are in the
/// other array of items.
TreeBuilder::Subtree TreeBuilder::split(Subtree& range, std::span<Chunk> chunks, TreeNode* nodes, Executor& executor) {
  in_chunks(range, chunks, executor,
            [](Chunk& chunk, std::span<const BuildItem> items) { chunk.keys = range_of_keys(items); });
  BuildBox keys = chunks[0].keys;
  for (const Chunk& chunk : chunks.subspan(1)) keys.add(chunk.keys);
  const BuildBins bins(keys);
  std::size_t widest = 0;
  for (std::size_t c = 1; c < 3; ++c)
    if (keys.extent(c) > keys.extent(widest)) widest = c;
  const bool binned = range.end - range.begin >= kMinBinned && !bins.none();
  const Index middle = binned ? split_bins(range, bins, chunks, executor) : split_at_median(range, widest);
  const Index left_nodes = tree_nodes(middle - range.begin, leaf_size_);
  const Subtree right{range.node + 1 + left_nodes, middle, range.end, range.depth + 1, 1 - range.side};
  nodes[range.node] = {offset_ + range.begin, offset_ + range.end, right.node, FilterKeys::kMixed};
  range = {range.node + 1, range.begin, middle, range.depth + 1, 1 - range.side};
  return right;
}

/// Moves the items in ascending order of their keys, or, if they are many, only divides them at the median.
Index TreeBuilder::split_at_median(const Subtree& range, std::size_t axis) {
  const Index count = range.end - range.begin;
  const Index middle = (count + leaf_size_ - 1) / leaf_size_ / 2 * leaf_size_;
  const BuildItem* const items = items_[range.side].get() + range.begin;
  BuildItem* const out = items_[1 - range.side].get() + range.begin;
  if (count >= kMinBinned) {
    std::copy_n(items, count, out);
    std::nth_element(out, out + middle, out + count,
                     [axis](const BuildItem& x, const BuildItem& y) { return x.box.key(axis) < y.box.key(axis); });
    return range.begin + middle;
  }
  // All pairs are compared, because branches that depend on the keys would be mispredicted.
  std::array<float, kMinBinned> keys;
  std::array<Index, kMinBinned> ranks;
  for (Index j = 0; j < count; ++j) {
    keys[j] = items[j].box.key(axis);
    Index later = 0;  // number of preceding items with a greater key
    for (Index i = 0; i < j; ++i) {
      const Index less = keys[j] < keys[i] ? 1 : 0;
      ranks[i] += less;
      later += less;
    }
    ranks[j] = j - later;
  }
  for (Index i = 0; i < count; ++i) out[ranks[i]] = items[i];
  return range.begin + middle;
}

/// Surface-area heuristic. The ratio of the halves is limited to 1 : 7, which bounds the depth.
Index TreeBuilder::split_bins(const Subtree& range, const BuildBins& bins, std::span<Chunk> chunks,
                              Executor& executor) {
  in_chunks(range, chunks, executor,
            [&](Chunk& chunk, std::span<const BuildItem> items) { fill_bins(items, bins, chunk.bins); });
  const Index leaves = (range.end - range.begin + leaf_size_ - 1) / leaf_size_;
  Split best{std::numeric_limits<double>::infinity(), 0, leaves / 2};
  std::array<BuildBins::Bin, kBins> sums;
  for (std::size_t c = 0; c < 3; ++c) {
    if (bins.scale[c] == 0) continue;
    if (chunks.size() > 1) sums = chunks[0].bins[c];
    for (const Chunk& chunk : chunks.subspan(1))
      for (std::size_t b = 0; b < kBins; ++b) add(sums[b], chunk.bins[c][b]);
    sweep_bins(chunks.size() > 1 ? sums : chunks[0].bins[c], c, leaf_size_, best);
  }
  const Index min = std::max<Index>(1, leaves / 8);
  const Index middle = range.begin + std::clamp(best.left_leaves, min, leaves - min) * leaf_size_;
  partition(range, bins, best.axis, middle, chunks, executor);
  return middle;
}

/// Moves the items to the other array, those of the bins before the bin with the position `middle` first, and those of
/// the bins after it last. The order of the chunks, and that in each of them, is kept.
void TreeBuilder::partition(const Subtree& range, const BuildBins& bins, std::size_t axis, Index middle,
                            std::span<Chunk> chunks, Executor& executor) {
  std::size_t bin = 0;
  Index before = 0, within = 0;
  for (before = range.begin;; before += within, ++bin) {
    within = 0;
    for (const Chunk& chunk : chunks) within += chunk.bins[axis][bin].count;
    if (before + within > middle) break;
  }
  std::array<Index, 3> next{range.begin, before, before + within};
  for (Chunk& chunk : chunks) {
    chunk.places = next;
    for (std::size_t b = 0; b < kBins; ++b) next[(b >= bin) + (b > bin)] += chunk.bins[axis][b].count;
  }
  BuildItem* const out = items_[1 - range.side].get();
  in_chunks(range, chunks, executor, [&](const Chunk& chunk, std::span<const BuildItem> items) {
    std::array<Index, 3> at = chunk.places;
    for (const BuildItem& item : items) {
      const std::size_t b = bins.bin(item, axis);
      out[at[(b >= bin) + (b > bin)]++] = item;
    }
  });
  if (before < middle)
    std::nth_element(out + before, out + middle, out + before + within,
                     [axis](const BuildItem& x, const BuildItem& y) { return x.box.key(axis) < y.box.key(axis); });
}

}  // namespace volccd::detail
