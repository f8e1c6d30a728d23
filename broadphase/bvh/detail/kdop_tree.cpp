#include <volccd/broadphase/bvh/detail/kdop_tree.hpp>

#include <algorithm>

#include <volccd/broadphase/bvh/detail/tree_kernels.hpp>

namespace volccd::detail {

namespace {

/// A rebuild is due when more than 1/kGapDenominator of the elements were removed, or more than 1/kAddedDenominator of
/// them plus kAddedAllowance were added.
constexpr std::size_t kGapDenominator = 4, kAddedDenominator = 16, kAddedAllowance = 64;
constexpr std::size_t max_added(std::size_t built) { return built / kAddedDenominator + kAddedAllowance; }

/// Subtrees with fewer elements are not restructured separately.
constexpr Index kMinRestructured = 64;
constexpr std::size_t kElementsPerTask = 4096;

double ratio(const TreeCost& cost) { return cost.elements > 0 ? cost.nodes / cost.elements : 0; }

}  // namespace

void KdopTree::build(const Step& step, int leaf_size, const BoundsTable& vertices, Executor& executor) {
  leaf_size_ = static_cast<Index>(leaf_size);
  list_elements(step.mesh(), slots_);
  built_elements_ = static_cast<Index>(slots_.size());
  slots_.resize(slots_.size() + kPadding, kNone);
  gaps_ = 0;
  depth_ = 0;
  roots_.clear();
  adjacent_leaves_.clear();
  positions_.assign(step.mesh().element_slots(), kNone);
  for (BoundsTable* bounds : {&element_bounds_, &node_bounds_}) bounds->resize(0, vertices.width());
  add_tree(step, 0, vertices, executor);
  refit(step, vertices, executor);
  if (!roots_.empty()) note_costs(0);
}

/// Adds a tree over the elements from position `begin` on, if there are any, after a tree over the others.
void KdopTree::add_tree(const Step& step, Index begin, const BoundsTable& vertices, Executor& executor) {
  const Index end = static_cast<Index>(size()), first = begin == 0 ? 0 : nodes_of(begin);
  nodes_.resize(end == begin ? first : first + nodes_of(end - begin));
  element_bounds_.grow(end + kPadding, begin);
  node_bounds_.grow(nodes_.size(), first);
  costs_.resize(nodes_.size());
  built_ratios_.resize(nodes_.size());
  if (end > begin) {
    roots_.push_back(first);
    depth_ = std::max(depth_, build_subtree(step, {first, begin, end, 0}, vertices, scratch_[0], executor));
  }
  find_blocks();
  for (std::size_t p = end; p < slots_.size(); ++p)
    std::fill_n(element_bounds_.row(p), 2 * element_bounds_.width(), 0.0f);
}

/// Whether the bounds of the element at a position overlap those of its last refit.
bool KdopTree::is_near(const Step& step, Index position, const BoundsTable& vertices) const {
  const float* const last = element_bounds_.row(position);
  const auto axes = static_cast<std::size_t>(vertices.width());
  const std::span<const Index> corners = step.topology.adjacency().vertices(slots_[position]);
  const auto some = [&](auto&& predicate) { return std::ranges::any_of(corners, predicate); };
  for (std::size_t axis = 0; axis < axes; ++axis)
    if (!some([&](Index v) { return vertices.row(v)[axis] <= last[axes + axis]; }) ||
        !some([&](Index v) { return vertices.row(v)[axes + axis] >= last[axis]; }))
      return false;
  return true;
}

bool KdopTree::edit(const Step& step, const std::vector<Index>& touched, const BoundsTable& vertices,
                    Executor& executor) {
  const Mesh& mesh = step.mesh();
  positions_.resize(mesh.element_slots(), kNone);
  added_.clear();  // slots of the second tree
  for (std::size_t p = built_elements_; p < size(); ++p)
    if (!std::binary_search(touched.begin(), touched.end(), slots_[p])) added_.push_back(slots_[p]);
  for (const Index slot : touched) {
    if (const Index position = positions_[slot]; position < built_elements_) {
      if (mesh.is_live(slot) && is_near(step, position, vertices)) {
        adjacent_leaves_.remove(position, position + 1);
        continue;
      }
      slots_[position] = kNone;
      ++gaps_;
    }
    positions_[slot] = kNone;
    if (mesh.is_live(slot)) added_.push_back(slot);
  }
  if (gaps_ > built_elements_ / kGapDenominator || added_.size() > max_added(built_elements_)) return false;

  slots_.resize(built_elements_);
  slots_.insert(slots_.end(), added_.begin(), added_.end());
  slots_.resize(slots_.size() + kPadding, kNone);
  roots_.resize(built_elements_ == 0 ? 0 : 1);
  add_tree(step, built_elements_, vertices, executor);
  return true;
}

/// Makes the nodes of a subtree, and reorders the list accordingly. Returns the depth of the deepest leaf.
int KdopTree::build_subtree(const Step& step, const TreeBuilder::Subtree& subtree, const BoundsTable& vertices,
                            BuildScratch& scratch, Executor& executor) {
  const int depth = scratch.builder.build(list(step), vertices, subtree, leaf_size_, nodes_.data(), executor);
  const Index offset = subtree.begin, count = subtree.end - offset;
  const std::span<const Index> order = scratch.builder.order(), former = slots().subspan(offset, count);
  scratch.slots.assign(former.begin(), former.end());
  executor.parallel_for(count, kElementsPerTask, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index slot = slots_[offset + i] = scratch.slots[order[i] - offset];
      if (slot != kNone) positions_[slot] = offset + static_cast<Index>(i);
    }
  });
  return depth;
}

void KdopTree::find_blocks() {
  blocks_.clear();
  upper_.clear();
  const Index max = std::max<Index>(1024, static_cast<Index>(size() / 64));
  for (Index root = 0; root < nodes_.size();) {
    if (nodes_[root].size() <= max) {
      blocks_.push_back(root);
      root = subtree_end(root);
    } else {
      upper_.push_back(root++);
    }
  }
}

void KdopTree::refit_nodes(const ElementList& list, const BoundsTable& vertices, Index begin, Index end) {
  refit_range({nodes_.data(), &list, &vertices, &node_bounds_, &element_bounds_, costs_.data()}, begin, end);
}

void KdopTree::refit(const Step& step, const BoundsTable& vertices, Executor& executor) {
  const ElementList elements = list(step);
  executor.parallel_for(blocks_.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) refit_nodes(elements, vertices, blocks_[i], subtree_end(blocks_[i]));
  });
  for (std::size_t i = upper_.size(); i-- > 0;) refit_nodes(elements, vertices, upper_[i], upper_[i] + 1);
}

void KdopTree::note_costs(Index node) {
  for (Index i = node, end = subtree_end(node); i < end; ++i) built_ratios_[i] = static_cast<float>(ratio(costs_[i]));
}

/// Appends the roots of the subtrees below `node` that must be rebuilt to degraded_: the node itself if its cost has
/// grown too much, unless only one child is the cause.
void KdopTree::collect_degraded(Index node, int depth, double degradation) {
  const TreeNode& n = nodes_[node];
  if (n.right == 0 || n.size() < kMinRestructured) return;
  const auto excess = [&](Index i) {
    return costs_[i].nodes - static_cast<double>(built_ratios_[i]) * costs_[i].elements;
  };
  const auto degraded = [&](Index i) {
    return costs_[i].nodes > degradation * static_cast<double>(built_ratios_[i]) * costs_[i].elements;
  };
  if (degraded(node)) {
    const Index culprit = excess(node + 1) > excess(n.right) ? node + 1 : n.right;
    if (nodes_[culprit].size() >= kMinRestructured && degraded(culprit) && excess(culprit) >= 0.75 * excess(node))
      return collect_degraded(culprit, depth + 1, degradation);
    degraded_.push_back({node, depth});
    return;
  }
  collect_degraded(node + 1, depth + 1, degradation);
  collect_degraded(n.right, depth + 1, degradation);
}

void KdopTree::rebuild(const Step& step, Degraded& degraded, const BoundsTable& vertices, BuildScratch& scratch,
                       Executor& executor) {
  const Index node = degraded.node, begin = nodes_[node].begin, end = nodes_[node].end;
  degraded.depth = build_subtree(step, {node, begin, end, degraded.depth}, vertices, scratch, executor);
  refit_nodes(list(step), vertices, node, subtree_end(node));
  note_costs(node);
}

std::size_t KdopTree::restructure(const Step& step, double degradation, const BoundsTable& vertices,
                                  Executor& executor) {
  if (built_elements_ == 0) return 0;
  degraded_.clear();
  collect_degraded(0, 0, degradation);
  if (degraded_.empty()) return 0;
  if (scratch_.size() < executor.workers()) scratch_.resize(executor.workers());
  // All threads rebuild a large subtree together, and one thread a small one.
  const auto size = [&](const Degraded& d) { return nodes_[d.node].size(); };
  const auto small =
      std::partition(degraded_.begin(), degraded_.end(), [&](const Degraded& d) { return size(d) > kElementsPerTask; });
  for (auto d = degraded_.begin(); d != small; ++d) rebuild(step, *d, vertices, scratch_[0], executor);
  const auto count = static_cast<std::size_t>(degraded_.end() - small);
  executor.parallel_for(count, 1, [&](std::size_t first, std::size_t last, unsigned worker) {
    SerialExecutor serial;
    for (std::size_t i = first; i < last; ++i)
      rebuild(step, small[static_cast<std::ptrdiff_t>(i)], vertices, scratch_[worker], serial);
  });
  std::size_t elements = 0;
  for (const Degraded& d : degraded_) {
    adjacent_leaves_.remove(nodes_[d.node].begin, nodes_[d.node].end);
    depth_ = std::max(depth_, d.depth);
    elements += size(d);
  }
  find_blocks();
  return elements;
}

void KdopTree::set_keys(const FilterKeys& keys) {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    TreeNode& node = nodes_[i];
    if (node.right != 0) {
      const std::int32_t left = nodes_[i + 1].key, right = nodes_[node.right].key;
      node.key = left == right ? left : FilterKeys::kMixed;
      continue;
    }
    bool first = true;
    node.key = FilterKeys::kMixed;
    for (Index p = node.begin; p < node.end; ++p) {
      if (slots_[p] == kNone) continue;
      const std::int32_t key = keys.key(slots_[p]);
      node.key = first || key == node.key ? key : FilterKeys::kMixed;
      first = false;
      if (node.key == FilterKeys::kMixed) break;
    }
  }
}

}  // namespace volccd::detail
