#include <volccd/broadphase/detail/kdop_tree.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <volccd/broadphase/detail/tree_kernels.hpp>

namespace volccd::detail {

namespace {

/// A rebuild is due when more than 1/kGapDenominator of the elements were removed, or more than 1/kAddedDenominator of
/// them plus kAddedAllowance were added.
constexpr std::size_t kGapDenominator = 4, kAddedDenominator = 32, kAddedAllowance = 64;
/// Subtrees with fewer elements than kLeastRestructured are not restructured separately; ranges with fewer than
/// kLeastBinned are split at the median.
constexpr Index kLeastRestructured = 64, kLeastBinned = 32;
constexpr int kBins = 16;
constexpr int kMixedKey = FilterKeys::kMixed;

double ratio(const TreeCost& cost) { return cost.elements > 0 ? cost.nodes / cost.elements : 0; }

}  // namespace

/// A box in doubles, because their differences of floats cannot overflow.
struct KdopTree::Box {
  std::array<double, 3> lo, hi;

  Box() {
    lo.fill(std::numeric_limits<double>::infinity());
    hi.fill(-std::numeric_limits<double>::infinity());
  }
  template <class Corner>
  void add(const Corner& low, const Corner& high) {
    for (std::size_t c = 0; c < 3; ++c) {
      lo[c] = std::min(lo[c], static_cast<double>(low[c]));
      hi[c] = std::max(hi[c], static_cast<double>(high[c]));
    }
  }
  double extent(int axis) const { return hi[static_cast<std::size_t>(axis)] - lo[static_cast<std::size_t>(axis)]; }
  double half_area() const {
    const double x = extent(0), y = extent(1), z = extent(2);
    return x >= 0 ? x * y + y * z + z * x : 0;
  }
};

struct KdopTree::Split {
  double cost;
  int axis;
  Index left_leaves;
};

double KdopTree::centre(const BuildItem& item, std::size_t axis) {
  return 0.5 * (static_cast<double>(item.lo[axis]) + static_cast<double>(item.hi[axis]));
}

void KdopTree::build(const Step& step, int leaf_size, const BoundsTable& vertices, Executor& executor) {
  leaf_size_ = static_cast<Index>(leaf_size);
  list_.assign(step);
  const Index count = static_cast<Index>(list_.size());
  built_elements_ = count;
  gaps_ = 0;
  depth_ = 0;
  roots_.clear();
  nodes_.clear();
  adjacent_leaves_.clear();
  positions_.assign(step.mesh().element_slots(), kNone);
  element_bounds_.resize(count + LeafLanes::kPadding, vertices.width());
  bound_elements(vertices, list_, executor, element_bounds_);
  node_bounds_.resize(count == 0 ? 0 : nodes_of(count), vertices.width());
  if (count > 0) {
    nodes_.resize(nodes_of(count));
    roots_.push_back(0);
    gather_items(0, count);
    build_range({0, 0, count, 0}, executor);
  }
  costs_.resize(nodes_.size());
  built_ratios_.resize(nodes_.size());
  find_blocks();
  make_lanes();
  refit(vertices, executor);
  if (count > 0) note_costs(0);
}

bool KdopTree::edit(const Step& step, const std::vector<Index>& touched, const BoundsTable& vertices,
                    Executor& executor) {
  positions_.resize(step.mesh().element_slots(), kNone);
  order_.clear();  // slots of the second tree
  for (std::size_t p = built_elements_; p < list_.size(); ++p)
    if (!std::binary_search(touched.begin(), touched.end(), list_.slot(p))) order_.push_back(list_.slot(p));
  for (const Index slot : touched) {
    if (positions_[slot] < built_elements_ && list_.replace_part(step, positions_[slot])) continue;
    if (positions_[slot] < built_elements_) {
      list_.make_gap(positions_[slot]);
      ++gaps_;
    }
    positions_[slot] = kNone;
    if (step.takes_part(slot)) order_.push_back(slot);
  }
  if (gaps_ > built_elements_ / kGapDenominator ||
      order_.size() > built_elements_ / kAddedDenominator + kAddedAllowance)
    return false;

  list_.truncate(built_elements_);
  for (const Index slot : order_) list_.append(step, slot);
  const Index end = static_cast<Index>(list_.size());
  const Index first = built_elements_ == 0 ? 0 : nodes_of(built_elements_);
  nodes_.resize(end == built_elements_ ? first : first + nodes_of(end - built_elements_));
  roots_.resize(built_elements_ == 0 ? 0 : 1);
  element_bounds_.grow(end + LeafLanes::kPadding, built_elements_);
  node_bounds_.grow(nodes_.size(), first);
  costs_.resize(nodes_.size());
  built_ratios_.resize(nodes_.size());
  if (end > built_elements_) {
    roots_.push_back(first);
    bound_elements(vertices, list_, built_elements_, end, element_bounds_);
    gather_items(built_elements_, end);
    build_range({first, built_elements_, end, 0}, executor);
  }
  find_blocks();
  make_lanes();
  return true;
}

void KdopTree::gather_items(Index begin, Index end) {
  items_.resize(end - begin);
  const std::size_t width = static_cast<std::size_t>(element_bounds_.width());
  // Gaps take the box of a live element, so that they do not affect the splits or introduce infinities.
  const float zero[BoundsTable::kMostFloats] = {};
  const float* stand_in = zero;
  for (Index p = begin; p < end && stand_in == zero; ++p)
    if (list_.slot(p) != kNone) stand_in = element_bounds_.row(p);
  for (Index p = begin; p < end; ++p) {
    BuildItem& item = items_[p - begin];
    const float* const row = list_.slot(p) != kNone ? element_bounds_.row(p) : stand_in;
    std::copy_n(row, 3, item.lo.begin());
    std::copy_n(row + width, 3, item.hi.begin());
    item.position = p;
  }
}

/// Builds the subtree of a range whose elements are in items_, and reorders the list accordingly.
void KdopTree::build_range(Range range, Executor& executor) {
  const Index begin = range.begin, count = range.end - range.begin;
  const Index grain = std::max<Index>(2048, count / 64);
  range.begin = 0, range.end = count;  // positions within items_
  tasks_.assign(1, range);
  for (std::size_t i = 0; i < tasks_.size();) {
    if (tasks_[i].end - tasks_[i].begin <= grain) {
      ++i;
      continue;
    }
    Range left = tasks_[i];
    const Range right = split(left, begin);
    tasks_[i] = left;
    tasks_.push_back(right);
  }
  executor.parallel_for(tasks_.size(), 1, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t i = first; i < last; ++i) tasks_[i].depth = build_subtree(tasks_[i], begin);
  });
  for (const Range& task : tasks_) depth_ = std::max(depth_, task.depth);

  order_.resize(count);
  for (Index i = 0; i < count; ++i) order_[i] = items_[i].position;
  list_.permute(begin, order_);
  for (Index p = begin; p < begin + count; ++p)
    if (list_.slot(p) != kNone) positions_[list_.slot(p)] = p;
}

/// Returns the depth of the deepest leaf.
int KdopTree::build_subtree(Range range, Index offset) {
  if (range.end - range.begin <= leaf_size_) {
    nodes_[range.node] = {offset + range.begin, offset + range.end, 0, kMixedKey};
    return range.depth;
  }
  const Range right = split(range, offset);
  const int depth = build_subtree(range, offset);
  return std::max(depth, build_subtree(right, offset));
}

/// Makes an inner node of the range, sets `range` to its left half and returns the right half.
KdopTree::Range KdopTree::split(Range& range, Index offset) {
  int axis = 0;
  const Index middle = split_position(range, axis);
  const auto c = static_cast<std::size_t>(axis);
  std::nth_element(items_.begin() + range.begin, items_.begin() + middle, items_.begin() + range.end,
                   [c](const BuildItem& x, const BuildItem& y) { return x.lo[c] + x.hi[c] < y.lo[c] + y.hi[c]; });
  const Range right{range.node + 1 + nodes_of(middle - range.begin), middle, range.end, range.depth + 1};
  nodes_[range.node] = {offset + range.begin, offset + range.end, right.node, kMixedKey};
  range = {range.node + 1, range.begin, middle, range.depth + 1};
  return right;
}

/// Surface-area heuristic with bins of the box centres on each axis; small ranges are split at the median of the widest
/// axis. The ratio of the halves is limited to 1 : 7, which bounds the depth.
Index KdopTree::split_position(Range range, int& axis) const {
  const Index count = range.end - range.begin, leaves = (count + leaf_size_ - 1) / leaf_size_;
  Box centres;
  for (Index i = range.begin; i < range.end; ++i) {
    const std::array<double, 3> p{centre(items_[i], 0), centre(items_[i], 1), centre(items_[i], 2)};
    centres.add(p, p);
  }
  Split best{std::numeric_limits<double>::infinity(), 0, leaves / 2};
  for (int c = 1; c < 3; ++c)
    if (centres.extent(c) > centres.extent(best.axis)) best.axis = c;
  if (count >= kLeastBinned)
    for (int c = 0; c < 3; ++c)
      if (centres.extent(c) > 0) sweep_bins(range, c, centres, best);
  axis = best.axis;
  const Index least = std::max<Index>(1, leaves / 8);
  return range.begin + std::clamp(best.left_leaves, least, leaves - least) * leaf_size_;
}

/// Selects the best boundary between bins on this axis, if it is cheaper than the best so far.
void KdopTree::sweep_bins(Range range, int axis, const Box& centres, Split& best) const {
  struct Bin {
    Box box;
    std::size_t count = 0;
    void add(const Bin& other) {
      box.add(other.box.lo, other.box.hi);
      count += other.count;
    }
    double cost() const { return box.half_area() * static_cast<double>(count); }
  };
  const auto c = static_cast<std::size_t>(axis);
  const double scale = kBins / centres.extent(axis);
  std::array<Bin, kBins> bins;
  for (Index i = range.begin; i < range.end; ++i) {
    const double at = (centre(items_[i], c) - centres.lo[c]) * scale;
    Bin& bin = bins[static_cast<std::size_t>(std::clamp(at, 0.0, kBins - 1.0))];
    bin.box.add(items_[i].lo, items_[i].hi);
    ++bin.count;
  }
  std::array<double, kBins> right_cost{};
  Bin right, left;
  for (std::size_t b = kBins; b-- > 1;) {
    right.add(bins[b]);
    right_cost[b] = right.cost();
  }
  for (std::size_t b = 0; b + 1 < kBins; ++b) {
    left.add(bins[b]);
    const double cost = left.cost() + right_cost[b + 1];
    if (cost < best.cost) best = {cost, axis, static_cast<Index>((left.count + leaf_size_ / 2) / leaf_size_)};
  }
}

LeafLanes KdopTree::lanes() const {
  return {lanes_.data() + lane_stride_, lanes_.data(), lane_stride_, lane_vertices_};
}

/// Allocates and fills the rows for the whole list.
void KdopTree::make_lanes() {
  std::size_t most = 0;
  for (std::size_t p = 0; p < list_.size(); ++p) most = std::max(most, list_.vertices(p).size());
  lane_vertices_ = most <= 4 ? 4 : most <= 8 ? 8 : 0;
  lane_stride_ = list_.size() + LeafLanes::kPadding;
  lanes_.assign(lane_stride_ * static_cast<std::size_t>(1 + lane_vertices_), kNone);
  for (std::size_t p = list_.size(); p < lane_stride_; ++p)  // read together with the last leaf, and ignored
    std::fill_n(element_bounds_.row(p), 2 * element_bounds_.width(), 0.0f);
  fill_lanes(0, list_.size());
}

void KdopTree::fill_lanes(std::size_t begin, std::size_t end) {
  const auto rows = static_cast<std::size_t>(lane_vertices_);
  for (std::size_t p = begin; p < end; ++p) {
    lanes_[p] = list_.slot(p);
    const std::span<const Index> vertices = list_.vertices(p);
    for (std::size_t v = 0; v < rows; ++v)
      lanes_[(1 + v) * lane_stride_ + p] = list_.slot(p) == kNone ? kNone : vertices[v < vertices.size() ? v : 0];
  }
}

void KdopTree::find_blocks() {
  blocks_.clear();
  upper_.clear();
  const Index most = std::max<Index>(1024, static_cast<Index>(list_.size() / 64));
  for (Index root = 0; root < nodes_.size();) {
    const TreeNode& node = nodes_[root];
    if (node.end - node.begin <= most) {
      blocks_.push_back(root);
      root += nodes_of(node.end - node.begin);  // in preorder, the next node outside of the subtree
    } else {
      upper_.push_back(root++);
    }
  }
}

void KdopTree::refit(const BoundsTable& vertices, Executor& executor) {
  const RefitArrays arrays{nodes_.data(), &list_, &vertices, &node_bounds_, &element_bounds_, costs_.data()};
  executor.parallel_for(blocks_.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const TreeNode& node = nodes_[blocks_[i]];
      refit_range(arrays, blocks_[i], blocks_[i] + nodes_of(node.end - node.begin));
    }
  });
  for (std::size_t i = upper_.size(); i-- > 0;) refit_range(arrays, upper_[i], upper_[i] + 1);
}

int KdopTree::depth_of(Index node) const {
  int depth = 0;
  for (Index i = 0; i != node; ++depth) i = node < nodes_[i].right ? i + 1 : nodes_[i].right;
  return depth;
}

void KdopTree::note_costs(Index node) {
  const Index end = node + nodes_of(nodes_[node].end - nodes_[node].begin);
  for (Index i = node; i < end; ++i) built_ratios_[i] = static_cast<float>(ratio(costs_[i]));
}

/// Appends the roots of the subtrees below `node` that must be rebuilt to degraded_: the node itself if its cost has
/// grown too much, unless only one child is the cause.
void KdopTree::collect_degraded(Index node, double degradation) {
  const TreeNode& n = nodes_[node];
  if (n.right == 0 || n.end - n.begin < kLeastRestructured) return;
  const auto excess = [&](Index i) {
    return costs_[i].nodes - static_cast<double>(built_ratios_[i]) * costs_[i].elements;
  };
  const auto degraded = [&](Index i) {
    return costs_[i].nodes > degradation * static_cast<double>(built_ratios_[i]) * costs_[i].elements;
  };
  if (degraded(node)) {
    const Index culprit = excess(node + 1) > excess(n.right) ? node + 1 : n.right;
    const bool large = nodes_[culprit].end - nodes_[culprit].begin >= kLeastRestructured;
    if (large && degraded(culprit) && excess(culprit) >= 0.75 * excess(node))
      return collect_degraded(culprit, degradation);
    degraded_.push_back(node);
    return;
  }
  collect_degraded(node + 1, degradation);
  collect_degraded(n.right, degradation);
}

std::size_t KdopTree::restructure(double degradation, const BoundsTable& vertices, Executor& executor) {
  if (built_elements_ == 0) return 0;
  degraded_.clear();
  collect_degraded(0, degradation);
  if (degraded_.empty()) return 0;
  const RefitArrays arrays{nodes_.data(), &list_, &vertices, &node_bounds_, &element_bounds_, costs_.data()};
  std::size_t elements = 0;
  for (const Index node : degraded_) {
    const Index begin = nodes_[node].begin, end = nodes_[node].end;
    elements += end - begin;
    gather_items(begin, end);
    build_range({node, begin, end, depth_of(node)}, executor);
    adjacent_leaves_.forget(begin, end);
    fill_lanes(begin, end);
    refit_range(arrays, node, node + nodes_of(end - begin));
    note_costs(node);
  }
  find_blocks();
  return elements;
}

void KdopTree::set_keys(const FilterKeys& keys) {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    TreeNode& node = nodes_[i];
    if (node.right != 0) {
      const std::int32_t left = nodes_[i + 1].key, right = nodes_[node.right].key;
      node.key = left == right ? left : kMixedKey;
      continue;
    }
    bool first = true;
    node.key = kMixedKey;
    for (Index p = node.begin; p < node.end; ++p) {
      if (list_.slot(p) == kNone) continue;
      const std::int32_t key = keys.key(list_.slot(p));
      node.key = first || key == node.key ? key : kMixedKey;
      first = false;
      if (node.key == kMixedKey) break;
    }
  }
}

std::size_t KdopTree::bytes() const {
  return list_.bytes() + nodes_.capacity() * sizeof(TreeNode) + costs_.capacity() * sizeof(TreeCost) +
         built_ratios_.capacity() * sizeof(float) + node_bounds_.bytes() + element_bounds_.bytes() +
         (positions_.capacity() + lanes_.capacity() + blocks_.capacity() + upper_.capacity() + order_.capacity()) *
             sizeof(Index) +
         items_.capacity() * sizeof(BuildItem) + adjacent_leaves_.bytes();
}

}  // namespace volccd::detail
