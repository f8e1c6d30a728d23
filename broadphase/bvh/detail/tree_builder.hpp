// Top-down construction of a tree over element boxes with the surface-area heuristic.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/broadphase/bvh/detail/build_kernels.hpp>
#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>

namespace volccd::detail {

/// A node with the elements at positions [begin, end) of the list. `right` is the right child, or 0 for a leaf.
struct TreeNode {
  Index begin, end, right;
  std::int32_t key;  ///< common filter key of its elements, or FilterKeys::kMixed

  Index size() const { return end - begin; }
};

/// Number of nodes of a subtree with this number of elements, which is not 0.
inline Index tree_nodes(Index elements, Index leaf_size) { return 2 * ((elements + leaf_size - 1) / leaf_size) - 1; }

/// Makes subtrees. The object is kept for its memory, and for the order that a build leaves.
class TreeBuilder {
 public:
  /// A root, the positions [begin, end) of its elements, begin < end, and its depth. During a build: a node to be made,
  /// of items that are now in items_[side].
  struct Subtree {
    Index node, begin, end;
    int depth;
    std::size_t side = 0;
  };

  /// Writes the nodes of a subtree, in preorder, to nodes[subtree.node] and after it, and sets order(). The elements
  /// are divided by their bounds along x, y and z, gaps by those of another element. Returns the depth of the deepest
  /// leaf. The result does not depend on the number of threads.
  int build(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree, Index leaf_size,
            TreeNode* nodes, Executor& executor);

  /// The former positions of the elements of the last subtree, in the order of its leaves.
  std::span<const Index> order() const { return order_; }

  std::size_t bytes() const { return 2 * capacity_ * sizeof(BuildItem) + heap_bytes(order_, tasks_, chunks_); }

 private:
  /// A part of a range, and what one thread finds out about it.
  struct Chunk {
    BuildBox keys;
    BuildBins::Contents bins;
    std::array<Index, 3> places;  ///< where the first of its items goes in each of the three parts of partition()
  };

  void gather(const ElementList& list, const BoundsTable& vertices, const Subtree& subtree, Executor& executor);
  int build_range(Subtree range, Chunk& chunk, TreeNode* nodes);
  Subtree split(Subtree& range, std::span<Chunk> chunks, TreeNode* nodes, Executor& executor);
  Index split_at_median(const Subtree& range, std::size_t axis);
  Index split_bins(const Subtree& range, const BuildBins& bins, std::span<Chunk> chunks, Executor& executor);
  void partition(const Subtree& range, const BuildBins& bins, std::size_t axis, Index middle, std::span<Chunk> chunks,
                 Executor& executor);
  template <class Body>
  void in_chunks(const Subtree& range, std::span<Chunk> chunks, Executor& executor, Body&& body);

  Index leaf_size_ = 1, offset_ = 0;
  std::array<std::unique_ptr<BuildItem[]>, 2> items_;
  std::size_t capacity_ = 0;
  std::vector<Index> order_;
  std::vector<Subtree> tasks_;
  std::vector<Chunk> chunks_;
};

}  // namespace volccd::detail
