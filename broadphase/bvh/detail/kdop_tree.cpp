#include <volccd/broadphase/bvh/detail/kdop_tree.hpp>

#include <algorithm>

#include <volccd/broadphase/bvh/detail/tree_kernels.hpp>

namespace volccd::detail {

namespace {

/// A rebuild is due when more than 1/kGapDenominator of the elements were removed, or more than 1/kAddedDenominator of
/// them plus kAddedAllowance were added.
constexpr std::size_t kGapDenominator = 4, kAddedDenominator = 32, kAddedAllowance = 64;
constexpr std::size_t max_added(std::size_t built) { return built / kAddedDenominator + kAddedAllowance; }

/// Rows of vertices for elements with at most `vertices` vertices; 0 if they are too many for rows.
int vertex_rows_for(std::size_t vertices) { return vertices <= 4 ? 4 : vertices <= 8 ? 8 : 0; }
/// Subtrees with fewer elements are not restructured separately.
constexpr Index kMinRestructured = 64;
constexpr std::size_t kElementsPerTask = 4096;

double ratio(const TreeCost& cost) { return cost.elements > 0 ? cost.nodes / cost.elements : 0; }

}  // namespace

void KdopTree::build(const Step& step, int leaf_size, const BoundsTable& vertices, Executor& executor) {
  leaf_size_ = static_cast<Index>(leaf_size);
  list_.assign(step.mesh(), executor);
  built_elements_ = static_cast<Index>(list_.size());
  gaps_ = 0;
  depth_ = 0;
  roots_.clear();
  adjacent_leaves_.clear();
  positions_.assign(step.mesh().element_slots(), kNone);
  for (BoundsTable* bounds : {&element_bounds_, &node_bounds_}) bounds->resize(0, vertices.width());
  add_tree(step.adjacency(), 0, vertices, executor);
  refit(vertices, executor);
  if (!roots_.empty()) note_costs(0);
}

/// Adds a tree over the elements from position `begin` on, if there are any, after a tree over the others.
void KdopTree::add_tree(const Adjacency& adjacency, Index begin, const BoundsTable& vertices, Executor& executor) {
  const Index end = static_cast<Index>(list_.size()), first = begin == 0 ? 0 : nodes_of(begin);
  nodes_.resize(end == begin ? first : first + nodes_of(end - begin));
  element_bounds_.grow(end + LeafLanes::kPadding, begin);
  node_bounds_.grow(nodes_.size(), first);
  costs_.resize(nodes_.size());
  built_ratios_.resize(nodes_.size());
  if (end > begin) {
    roots_.push_back(first);
    depth_ = std::max(depth_, build_subtree({first, begin, end, 0}, vertices, scratch_[0], executor));
  }
  find_blocks();
  const int rows = vertex_rows_for(max_ids(adjacency, begin));
  const bool fits = begin > 0 && (lane_vertices_ == 0 || (rows != 0 && rows <= lane_vertices_));
  fits ? fill_lanes(adjacency, begin, end, executor) : make_lanes(adjacency, executor);
  end_lanes();
}

bool KdopTree::edit(const Step& step, const std::vector<Index>& touched, const BoundsTable& vertices,
                    Executor& executor) {
  const Mesh& mesh = step.mesh();
  positions_.resize(mesh.element_slots(), kNone);
  added_.clear();  // slots of the second tree
  for (std::size_t p = built_elements_; p < list_.size(); ++p)
    if (!std::binary_search(touched.begin(), touched.end(), list_.slot(p))) added_.push_back(list_.slot(p));
  for (const Index slot : touched) {
    if (const Index position = positions_[slot]; position < built_elements_) {
      list_.make_gap(position);
      ++gaps_;
      fill_lane(step.adjacency(), position);
    }
    positions_[slot] = kNone;
    if (mesh.is_live(slot)) added_.push_back(slot);
  }
  if (gaps_ > built_elements_ / kGapDenominator || added_.size() > max_added(built_elements_)) return false;

  list_.truncate(built_elements_);
  for (const Index slot : added_) list_.append(mesh, slot);
  roots_.resize(built_elements_ == 0 ? 0 : 1);
  add_tree(step.adjacency(), built_elements_, vertices, executor);
  return true;
}

/// Makes the nodes of a subtree, and reorders the list accordingly. Returns the depth of the deepest leaf.
int KdopTree::build_subtree(const TreeBuilder::Subtree& subtree, const BoundsTable& vertices, BuildScratch& scratch,
                            Executor& executor) {
  const int depth = scratch.builder.build(list_, vertices, subtree, leaf_size_, nodes_.data(), executor);
  list_.permute(subtree.begin, scratch.builder.order(), scratch.list, executor);
  const Index offset = subtree.begin, count = subtree.end - offset;
  executor.parallel_for(count, kElementsPerTask, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t p = offset + begin; p < offset + end; ++p)
      if (list_.slot(p) != kNone) positions_[list_.slot(p)] = static_cast<Index>(p);
  });
  return depth;
}

/// The most vertices that decide whether an element is adjacent, of the elements from position `begin` on.
std::size_t KdopTree::max_ids(const Adjacency& adjacency, std::size_t begin) const {
  std::size_t max = 0;
  for (std::size_t p = begin; p < list_.size(); ++p)
    if (list_.slot(p) != kNone) max = std::max(max, adjacency.vertices(list_.slot(p)).size());
  return max;
}

/// Allocates the rows, with room for what edits may add, and fills them for the whole list.
void KdopTree::make_lanes(const Adjacency& adjacency, Executor& executor) {
  lane_vertices_ = vertex_rows_for(max_ids(adjacency, 0));
  lane_stride_ = built_elements_ + max_added(built_elements_) + LeafLanes::kPadding;
  lanes_.resize(lane_stride_ * static_cast<std::size_t>(1 + lane_vertices_));
  fill_lanes(adjacency, 0, list_.size(), executor);
}

/// Fills what is read together with the last leaf, and ignored.
void KdopTree::end_lanes() {
  for (std::size_t p = list_.size(); p < list_.size() + LeafLanes::kPadding; ++p) {
    std::fill_n(element_bounds_.row(p), 2 * element_bounds_.width(), 0.0f);
    for (std::size_t row = 0; row < lanes_.size(); row += lane_stride_) lanes_[row + p] = kNone;
  }
}

void KdopTree::fill_lanes(const Adjacency& adjacency, std::size_t begin, std::size_t end, Executor& executor) {
  executor.parallel_for(end - begin, kElementsPerTask, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t p = begin + first; p < begin + last; ++p) fill_lane(adjacency, p);
  });
}

void KdopTree::fill_lane(const Adjacency& adjacency, std::size_t p) {
  const Index slot = lanes_[p] = list_.slot(p);
  const std::span<const Index> ids = slot == kNone ? std::span<const Index>() : adjacency.vertices(slot);
  for (std::size_t v = 0; v < static_cast<std::size_t>(lane_vertices_); ++v)
    lanes_[(1 + v) * lane_stride_ + p] = slot == kNone ? kNone : ids[v < ids.size() ? v : 0];
}

void KdopTree::find_blocks() {
  blocks_.clear();
  upper_.clear();
  const Index max = std::max<Index>(1024, static_cast<Index>(list_.size() / 64));
  for (Index root = 0; root < nodes_.size();) {
    if (nodes_[root].size() <= max) {
      blocks_.push_back(root);
      root = subtree_end(root);
    } else {
      upper_.push_back(root++);
    }
  }
}

void KdopTree::refit_nodes(const BoundsTable& vertices, Index begin, Index end) {
  refit_range({nodes_.data(), &list_, &vertices, &node_bounds_, &element_bounds_, costs_.data()}, begin, end);
}

void KdopTree::refit(const BoundsTable& vertices, Executor& executor) {
  executor.parallel_for(blocks_.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) refit_nodes(vertices, blocks_[i], subtree_end(blocks_[i]));
  });
  for (std::size_t i = upper_.size(); i-- > 0;) refit_nodes(vertices, upper_[i], upper_[i] + 1);
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

void KdopTree::rebuild(const Adjacency& adjacency, Degraded& degraded, const BoundsTable& vertices,
                       BuildScratch& scratch, Executor& executor) {
  const Index node = degraded.node, begin = nodes_[node].begin, end = nodes_[node].end;
  degraded.depth = build_subtree({node, begin, end, degraded.depth}, vertices, scratch, executor);
  fill_lanes(adjacency, begin, end, executor);
  refit_nodes(vertices, node, subtree_end(node));
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
  for (auto d = degraded_.begin(); d != small; ++d) rebuild(step.adjacency(), *d, vertices, scratch_[0], executor);
  const auto count = static_cast<std::size_t>(degraded_.end() - small);
  executor.parallel_for(count, 1, [&](std::size_t first, std::size_t last, unsigned worker) {
    SerialExecutor serial;
    for (std::size_t i = first; i < last; ++i)
      rebuild(step.adjacency(), small[static_cast<std::ptrdiff_t>(i)], vertices, scratch_[worker], serial);
  });
  std::size_t elements = 0;
  for (const Degraded& d : degraded_) {
    adjacent_leaves_.forget(nodes_[d.node].begin, nodes_[d.node].end);
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
      if (list_.slot(p) == kNone) continue;
      const std::int32_t key = keys.key(list_.slot(p));
      node.key = first || key == node.key ? key : FilterKeys::kMixed;
      first = false;
      if (node.key == FilterKeys::kMixed) break;
    }
  }
}

}  // namespace volccd::detail
