#include <volccd/broadphase/detail/tree_builder.hpp>

#include <algorithm>
#include <limits>

#include <volccd/broadphase/detail/filter_keys.hpp>

namespace volccd::detail {

namespace {

/// Ranges with fewer items are split at the median.
constexpr Index kLeastBinned = 32;
constexpr std::size_t kBins = 16;
/// A range that several threads split has at most kMostChunks chunks, of about kLeastChunk items or more.
constexpr Index kLeastChunk = 1024, kMostChunks = 64;

}  // namespace

/// Lower ends along x, y and z, and then negated upper ends; the last lane of both halves has no meaning.
struct ItemBox {
  std::array<float, 8> ends;

  static ItemBox empty() {
    ItemBox box;
    box.ends.fill(std::numeric_limits<float>::infinity());
    return box;
  }
  void add(const ItemBox& other) {
    for (std::size_t c = 0; c < 8; ++c) ends[c] = std::min(ends[c], other.ends[c]);
  }
  /// Twice the centre, which may overflow, and the end of the range of such values in a box of them.
  float key(std::size_t axis) const { return ends[axis] - ends[4 + axis]; }
  /// In doubles, because differences of floats may overflow.
  double extent(std::size_t axis) const {
    return -static_cast<double>(ends[4 + axis]) - static_cast<double>(ends[axis]);
  }
  double half_area() const {
    const double x = extent(0), y = extent(1), z = extent(2);
    return x >= 0 ? x * y + y * z + z * x : 0;
  }
};

struct ItemBin {
  ItemBox box;
  Index count;

  void add(const ItemBin& other) {
    box.add(other.box);
    count += other.count;
  }
  double cost() const { return box.half_area() * static_cast<double>(count); }
};

namespace {

struct Split {
  double cost;
  std::size_t axis;
  Index left_leaves;
};

/// Selects the best boundary between bins on this axis, if it is cheaper than the best so far.
void sweep_bins(const std::array<ItemBin, kBins>& bins, std::size_t axis, Index leaf_size, Split& best) {
  std::array<double, kBins> right_cost{};
  ItemBin right{ItemBox::empty(), 0}, left = right;
  for (std::size_t b = kBins; b-- > 1;) {
    right.add(bins[b]);
    right_cost[b] = right.cost();
  }
  for (std::size_t b = 0; b + 1 < kBins; ++b) {
    left.add(bins[b]);
    const double cost = left.cost() + right_cost[b + 1];
    if (cost < best.cost) best = {cost, axis, (left.count + leaf_size / 2) / leaf_size};
  }
}

}  // namespace

struct TreeBuilder::Item {
  ItemBox box;
  Index position;
};

/// A part of a range, and what one thread finds out about it.
struct TreeBuilder::Chunk {
  ItemBox keys;  ///< the range of the keys
  std::array<std::array<ItemBin, kBins>, 3> bins;
  std::array<Index, 3> places;  ///< where the first of its items goes in each of the three parts of split_bins()
};

/// The bins of a range, of equal size along each axis.
struct TreeBuilder::Bins {
  std::array<float, 4> first{}, scale{};  ///< scale: 0 for an axis that has no bins

  explicit Bins(const ItemBox& keys) {
    constexpr double most = std::numeric_limits<float>::max();
    for (std::size_t c = 0; c < 3; ++c)
      if (keys.extent(c) > 0 && keys.extent(c) <= 2 * most) {
        first[c] = keys.ends[c];
        scale[c] = static_cast<float>(std::min(kBins / keys.extent(c), most));
      }
  }
  bool none() const { return scale[0] == 0 && scale[1] == 0 && scale[2] == 0; }
  std::size_t of(const Item& item, std::size_t axis) const {
    const float at = (item.box.key(axis) - first[axis]) * scale[axis];
    return static_cast<std::size_t>(static_cast<int>(std::max(0.0f, std::min(kBins - 1.0f, at))));
  }
};

TreeBuilder::TreeBuilder() = default;
TreeBuilder::~TreeBuilder() = default;

int TreeBuilder::build(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree, Index leaf_size,
                       TreeNode* nodes, Executor& executor) {
  const Index count = subtree.end - subtree.begin;
  leaf_size_ = leaf_size;
  offset_ = subtree.begin;
  gather(list, vertices, subtree, executor);
  // Large ranges are split one after the other by all threads, until there are enough for each thread to take some.
  const Index grain = std::max<Index>(2048, count / (8 * executor.workers()));
  tasks_.assign(1, {subtree.node, 0, count, subtree.depth, 0});
  for (std::size_t i = 0; i < tasks_.size();) {
    const Index size = tasks_[i].end - tasks_[i].begin;
    if (size <= grain) {
      ++i;
      continue;
    }
    chunks_.resize(std::clamp<Index>(size / kLeastChunk, 1, kMostChunks));
    const Range right = split(tasks_[i], chunks_, nodes, executor);
    tasks_.push_back(right);
  }
  executor.parallel_for(tasks_.size(), 1, [&](std::size_t first, std::size_t last, unsigned) {
    Chunk chunk;
    for (std::size_t i = first; i < last; ++i) tasks_[i].depth = build_range(tasks_[i], chunk, nodes);
  });
  int depth = 0;
  for (const Range& task : tasks_) depth = std::max(depth, task.depth);
  return depth;
}

void TreeBuilder::gather(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree,
                         Executor& executor) {
  const std::size_t count = subtree.end - subtree.begin, width = static_cast<std::size_t>(vertices.width());
  order_.resize(count);
  if (capacity_ < count) {
    for (auto& items : items_) items = std::make_unique_for_overwrite<Item[]>(count);
    capacity_ = count;
  }
  const auto box = [&](std::size_t p) {
    ItemBox sum = ItemBox::empty();
    for (const Index v : list.part(p)) {
      const float* const row = vertices.row(v);
      for (std::size_t c = 0; c < 4; ++c) {
        sum.ends[c] = std::min(sum.ends[c], row[c]);
        sum.ends[4 + c] = std::min(sum.ends[4 + c], -row[width + c]);
      }
    }
    return sum;
  };
  // Gaps take the box of a live element, so that they do not affect the splits or introduce infinities.
  std::size_t live = subtree.begin;
  while (live < subtree.end && list.slot(live) == kNone) ++live;
  const ItemBox stand_in = live < subtree.end ? box(live) : ItemBox{};
  executor.parallel_for(count, 4096, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index p = subtree.begin + static_cast<Index>(i);
      items_[0][i] = {list.slot(p) == kNone ? stand_in : box(p), p};
    }
  });
}

/// Returns the depth of the deepest leaf.
int TreeBuilder::build_range(Range range, Chunk& chunk, TreeNode* nodes) {
  if (range.end - range.begin <= leaf_size_) {
    nodes[range.node] = {offset_ + range.begin, offset_ + range.end, 0, FilterKeys::kMixed};
    for (Index i = range.begin; i < range.end; ++i) order_[i] = items_[static_cast<std::size_t>(range.side)][i].position;
    return range.depth;
  }
  SerialExecutor serial;
  const Range right = split(range, {&chunk, 1}, nodes, serial);
  const int depth = build_range(range, chunk, nodes);
  return std::max(depth, build_range(right, chunk, nodes));
}

/// Calls body(chunk, begin, end) with the items of each chunk of a range.
template <class Body>
void TreeBuilder::in_chunks(const Range& range, std::span<Chunk> chunks, Executor& executor, Body&& body) {
  const Item* const items = items_[static_cast<std::size_t>(range.side)].get() + range.begin;
  const std::size_t count = range.end - range.begin, parts = chunks.size();
  executor.parallel_for(parts, 1, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t i = first; i < last; ++i) body(chunks[i], items + count * i / parts, items + count * (i + 1) / parts);
  });
}

/// Makes an inner node of the range, sets `range` to its left half and returns the right half. Both halves are in the
/// other array of items.
TreeBuilder::Range TreeBuilder::split(Range& range, std::span<Chunk> chunks, TreeNode* nodes, Executor& executor) {
  in_chunks(range, chunks, executor, [](Chunk& chunk, const Item* begin, const Item* end) {
    chunk.keys = ItemBox::empty();
    for (const Item* item = begin; item != end; ++item) {
      ItemBox key;
      for (std::size_t c = 0; c < 4; ++c) {
        key.ends[c] = item->box.key(c);
        key.ends[4 + c] = -key.ends[c];
      }
      chunk.keys.add(key);
    }
  });
  ItemBox keys = chunks[0].keys;
  for (const Chunk& chunk : chunks.subspan(1)) keys.add(chunk.keys);
  const Bins bins(keys);
  std::size_t widest = 0;
  for (std::size_t c = 1; c < 3; ++c)
    if (keys.extent(c) > keys.extent(widest)) widest = c;
  const bool binned = range.end - range.begin >= kLeastBinned && !bins.none();
  const Index middle = binned ? split_bins(range, bins, chunks, executor) : split_at_median(range, widest);
  const Index left_nodes = tree_nodes(middle - range.begin, leaf_size_);
  const Range right{range.node + 1 + left_nodes, middle, range.end, range.depth + 1, 1 - range.side};
  nodes[range.node] = {offset_ + range.begin, offset_ + range.end, right.node, FilterKeys::kMixed};
  range = {range.node + 1, range.begin, middle, range.depth + 1, 1 - range.side};
  return right;
}

/// Moves the items in ascending order of their keys, or, if they are many, only divides them at the median.
Index TreeBuilder::split_at_median(const Range& range, std::size_t axis) {
  const Index count = range.end - range.begin;
  const Index middle = (count + leaf_size_ - 1) / leaf_size_ / 2 * leaf_size_;
  const Item* const items = items_[static_cast<std::size_t>(range.side)].get() + range.begin;
  Item* const out = items_[static_cast<std::size_t>(1 - range.side)].get() + range.begin;
  if (count >= kLeastBinned) {
    std::copy_n(items, count, out);
    std::nth_element(out, out + middle, out + count,
                     [axis](const Item& x, const Item& y) { return x.box.key(axis) < y.box.key(axis); });
    return range.begin + middle;
  }
  // All pairs are compared, because branches that depend on the keys would be mispredicted.
  std::array<float, kLeastBinned> keys;
  std::array<Index, kLeastBinned> ranks;
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
Index TreeBuilder::split_bins(const Range& range, const Bins& bins, std::span<Chunk> chunks, Executor& executor) {
  in_chunks(range, chunks, executor, [&](Chunk& chunk, const Item* begin, const Item* end) {
    for (auto& axis : chunk.bins) axis.fill({ItemBox::empty(), 0});
    for (const Item* item = begin; item != end; ++item)
      for (std::size_t c = 0; c < 3; ++c) {
        ItemBin& bin = chunk.bins[c][bins.of(*item, c)];
        bin.box.add(item->box);
        ++bin.count;
      }
  });
  const Index leaves = (range.end - range.begin + leaf_size_ - 1) / leaf_size_;
  Split best{std::numeric_limits<double>::infinity(), 0, leaves / 2};
  std::array<ItemBin, kBins> sums;
  for (std::size_t c = 0; c < 3; ++c) {
    if (bins.scale[c] == 0) continue;
    sums = chunks[0].bins[c];
    for (const Chunk& chunk : chunks.subspan(1))
      for (std::size_t b = 0; b < kBins; ++b) sums[b].add(chunk.bins[c][b]);
    sweep_bins(sums, c, leaf_size_, best);
  }
  const Index least = std::max<Index>(1, leaves / 8);
  const Index middle = range.begin + std::clamp(best.left_leaves, least, leaves - least) * leaf_size_;
  partition(range, bins, best.axis, middle, chunks, executor);
  return middle;
}

/// Moves the items to the other array, those of the bins before the bin with the position `middle` first, and those of
/// the bins after it last. The order of the chunks, and that in each of them, is kept.
void TreeBuilder::partition(const Range& range, const Bins& bins, std::size_t axis, Index middle,
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
  Item* const out = items_[static_cast<std::size_t>(1 - range.side)].get();
  in_chunks(range, chunks, executor, [&](const Chunk& chunk, const Item* begin, const Item* end) {
    std::array<Index, 3> at = chunk.places;
    for (const Item* item = begin; item != end; ++item) {
      const std::size_t b = bins.of(*item, axis);
      out[at[(b >= bin) + (b > bin)]++] = *item;
    }
  });
  if (before < middle)
    std::nth_element(out + before, out + middle, out + before + within,
                     [axis](const Item& x, const Item& y) { return x.box.key(axis) < y.box.key(axis); });
}

std::size_t TreeBuilder::bytes() const {
  return 2 * capacity_ * sizeof(Item) + order_.capacity() * sizeof(Index) + tasks_.capacity() * sizeof(Range) +
         chunks_.capacity() * sizeof(Chunk);
}

}  // namespace volccd::detail
