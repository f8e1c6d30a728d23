// Binary tree of k-DOPs over an element list.
//
// Nodes are stored in preorder: the left child of node i is i + 1. Elements are split at multiples of the leaf size, so
// that a subtree of m elements has exactly 2 ceil(m / leaf_size) - 1 nodes, whatever its shape; therefore a subtree can
// be rebuilt in place. Leaves have consecutive positions of the list, which is kept in leaf order, so that a traversal
// reads contiguous memory.
//
// Elements that were added later follow the others, in a second tree in the same arrays.
#pragma once

#include <vector>

#include <volccd/broadphase/bvh/detail/adjacent_leaves.hpp>
#include <volccd/broadphase/bvh/detail/tree_builder.hpp>
#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The cost of a subtree: the squared half perimeters of the bounds, summed over its nodes and over its live elements.
/// The ratio of the two sums is independent of scale, and grows when elements move apart.
struct TreeCost {
  double nodes, elements;
};

class KdopTree {
 public:
  static constexpr int kMaxLeafSize = AdjacentLeaves::kMaskRow;
  static constexpr std::size_t kPadding = 4;

  /// Builds a tree with bounds over all live elements. `vertices` are the bounds of the vertices for this step.
  void build(const Step& step, int leaf_size, const BoundsTable& vertices, Executor& executor);

  /// Removes and adds elements. `touched`: slots whose elements may have changed since the last call. An element that
  /// is near the former one of its slot takes its place in the tree. Returns false if too many elements were removed or
  /// added since the last build; then build() must be called instead. Bounds become valid with the next refit().
  bool edit(const Step& step, const std::vector<Index>& touched, const BoundsTable& vertices, Executor& executor);

  /// Updates the bounds for another step. Linear time in the number of elements.
  void refit(const Step& step, const BoundsTable& vertices, Executor& executor);

  /// Rebuilds in place, with bounds, the subtrees whose cost ratio exceeds `degradation` times their ratio after their
  /// last build. Returns the number of elements in them. To be called after refit().
  std::size_t restructure(const Step& step, double degradation, const BoundsTable& vertices, Executor& executor);

  /// Frees the memory that only builds need, about 80 bytes for each element. For a tree that is rarely built.
  void free_scratch() { scratch_ = std::vector<BuildScratch>(1); }

  /// Updates adjacent_leaves(). They are empty after a build until this is called.
  void find_adjacent_leaves(const Step& step, Executor& executor) {
    adjacent_leaves_.update(slots().first(built_elements_), leaf_size_, step.adjacency(), step.mesh().vertex_count(),
                            executor);
  }

  /// Sets the keys of all nodes.
  void set_keys(const FilterKeys& keys);

  /// Elements by position, kNone for a gap. kPadding more slots, kNone, and their bounds, without meaning, may be read.
  std::span<const Index> slots() const { return std::span(slots_).first(size()); }
  const std::vector<TreeNode>& nodes() const { return nodes_; }
  const BoundsTable& node_bounds() const { return node_bounds_; }
  const BoundsTable& element_bounds() const { return element_bounds_; }
  const AdjacentLeaves& adjacent_leaves() const { return adjacent_leaves_; }
  /// Root nodes: none, one or two.
  std::vector<Index> const& roots() const { return roots_; }
  int depth() const { return depth_; }
  std::size_t bytes() const {
    return heap_bytes(slots_, nodes_, costs_, built_ratios_, node_bounds_, element_bounds_, positions_, blocks_, upper_,
                      adjacent_leaves_, added_, scratch_);
  }

 private:
  std::size_t size() const { return slots_.size() - kPadding; }
  ElementList list(const Step& step) const { return {slots(), step.topology.adjacency()}; }
  Index nodes_of(Index elements) const { return tree_nodes(elements, leaf_size_); }
  /// The next node, in preorder, outside of the subtree.
  Index subtree_end(Index node) const { return node + nodes_of(nodes_[node].size()); }
  /// Scratch memory for building a subtree.
  struct BuildScratch {
    TreeBuilder builder;
    std::vector<Index> slots;
    std::size_t bytes() const { return heap_bytes(builder, slots); }
  };
  /// A subtree to be rebuilt, and the depth of its root; after that, of its deepest leaf.
  struct Degraded {
    Index node;
    int depth;
  };
  bool is_near(const Step& step, Index position, const BoundsTable& vertices) const;
  void add_tree(const Step& step, Index begin, const BoundsTable& vertices, Executor& executor);
  int build_subtree(const Step& step, const TreeBuilder::Subtree& subtree, const BoundsTable& vertices,
                    BuildScratch& scratch, Executor& executor);
  void rebuild(const Step& step, Degraded& degraded, const BoundsTable& vertices, BuildScratch& scratch,
               Executor& executor);
  void refit_nodes(const ElementList& list, const BoundsTable& vertices, Index begin, Index end);
  void find_blocks();
  void note_costs(Index node);
  void collect_degraded(Index node, int depth, double degradation);

  Index leaf_size_ = 4;
  std::vector<Index> slots_ = std::vector<Index>(kPadding, kNone);  ///< by position, and padding
  std::vector<TreeNode> nodes_;
  std::vector<TreeCost> costs_;
  std::vector<float> built_ratios_;  ///< ratio of costs_ when the node was built
  std::vector<Index> roots_;
  Index built_elements_ = 0;  ///< number of elements of the first tree
  Index gaps_ = 0;
  int depth_ = 0;
  BoundsTable node_bounds_, element_bounds_;
  std::vector<Index> positions_;  ///< position of each slot
  std::vector<Index> blocks_;     ///< roots of disjoint subtrees that are refitted in parallel
  std::vector<Index> upper_;      ///< the nodes above `blocks_`, in preorder
  AdjacentLeaves adjacent_leaves_;
  // Scratch memory.
  std::vector<Index> added_;
  std::vector<Degraded> degraded_;
  std::vector<BuildScratch> scratch_{1};  ///< by worker
};

}  // namespace volccd::detail
