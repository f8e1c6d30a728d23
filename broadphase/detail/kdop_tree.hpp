// Binary tree of k-DOPs over an element list.
//
// Nodes lie in preorder: the left child of node i is i + 1. Splits fall on multiples of the leaf size, so that a
// subtree of m elements has exactly 2 ceil(m / leaf_size) - 1 nodes, whatever its shape: a subtree is restructured in
// its place. Leaves own consecutive positions of the list, which is kept in leaf order; what a traversal reads lies
// together.
//
// Elements that were added later stand behind the others, in a second tree in the same arrays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/executor.hpp>

namespace volccd::detail {

/// Elements at positions [begin, end) of the list. right == 0: a leaf; else the right child.
struct TreeNode {
  Index begin, end, right;
  std::int32_t key;  ///< common filter key of its elements, or FilterKeys::kMixed
};

/// Sizes summed over a subtree, a size being the squared half perimeter of a bound: over its nodes, and over the live
/// elements in it. Their ratio does not change with scale; it grows when elements drift apart.
struct TreeCost {
  double nodes, elements;
};

/// The list once more, as the leaf kernels read it: vertex v of the element at position p is ids[v * stride + p]. Short
/// elements repeat a vertex; gaps have kNone, as their slot too. All rows may be read kPadding positions past the end.
struct LeafLanes {
  static constexpr std::size_t kPadding = 4;

  const Index* ids;
  const Index* slots;
  std::size_t stride;
  int vertices;  ///< 4 or 8; 0: there are larger elements, and no ids
};

class KdopTree {
 public:
  static constexpr int kMostLeafSize = 8;

  /// A tree over all elements that take part, with bounds. `vertices` are the vertices' bounds of this step.
  void build(const Step& step, int leaf_size, const BoundsTable& vertices, Executor& executor);

  /// Takes elements out and puts others in. False if a build is due instead: too many of either have gathered since the
  /// last one. `touched`: slots whose taking part may have changed since the last call. Bounds are those of the next
  /// refit.
  bool edit(const Step& step, const std::vector<Index>& touched, const BoundsTable& vertices, Executor& executor);

  /// Bounds for another step. Time linear in the elements.
  void refit(const BoundsTable& vertices, Executor& executor);

  /// Rebuilds, in their place, the subtrees whose cost ratio exceeds `degradation` times that when they were built,
  /// with their bounds. Returns the number of elements in them. To be called after refit.
  std::size_t restructure(double degradation, const BoundsTable& vertices, Executor& executor);

  /// Fills in the nodes' keys.
  void set_keys(const FilterKeys& keys);

  int leaf_size() const { return static_cast<int>(leaf_size_); }
  const ElementList& list() const { return list_; }
  const std::vector<TreeNode>& nodes() const { return nodes_; }
  const BoundsTable& node_bounds() const { return node_bounds_; }
  const BoundsTable& element_bounds() const { return element_bounds_; }
  LeafLanes lanes() const;
  /// Root nodes: none, one or two.
  std::vector<Index> const& roots() const { return roots_; }
  int depth() const { return depth_; }
  std::size_t bytes() const;

 private:
  struct BuildItem {
    std::array<float, 3> lo, hi;
    Index position;
  };
  struct Range {
    Index node, begin, end;
    int depth;
  };
  struct Box;
  struct Split;

  Index nodes_of(Index elements) const { return 2 * ((elements + leaf_size_ - 1) / leaf_size_) - 1; }
  void build_range(Range range, Executor& executor);
  Range split(Range& range, Index offset);
  int build_subtree(Range range, Index offset);
  Index split_position(Range range, int& axis) const;
  void sweep_bins(Range range, int axis, const Box& centres, Split& best) const;
  static double centre(const BuildItem& item, std::size_t axis);
  void gather_items(Index begin, Index end);
  void find_blocks();
  void fill_lanes(std::size_t begin, std::size_t end);
  void make_lanes();
  int depth_of(Index node) const;
  void note_costs(Index node);
  void collect_degraded(Index node, double degradation);

  Index leaf_size_ = 4;
  ElementList list_;
  std::vector<TreeNode> nodes_;
  std::vector<TreeCost> costs_;
  std::vector<float> built_ratios_;  ///< costs_ as a ratio when the node was built
  std::vector<Index> roots_;
  Index built_elements_ = 0;  ///< of the first tree
  Index gaps_ = 0;
  int depth_ = 0;
  BoundsTable node_bounds_, element_bounds_;
  std::vector<Index> lanes_;      ///< rows of LeafLanes, slots first
  std::size_t lane_stride_ = 0;
  int lane_vertices_ = 4;
  std::vector<Index> positions_;  ///< slot -> position
  std::vector<Index> blocks_;     ///< roots of disjoint subtrees, refitted in parallel
  std::vector<Index> upper_;      ///< the nodes above them, in preorder
  // Scratch.
  std::vector<BuildItem> items_;
  std::vector<Index> order_, degraded_;
  std::vector<Range> tasks_;
};

}  // namespace volccd::detail
