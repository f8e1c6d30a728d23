// The inner loops of KdopTree, selected at run time for the instruction set of the processor.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/broadphase/bvh/detail/kdop_tree.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>

namespace volccd::detail {

/// Two nodes whose bounds overlap, or a node and itself (a == b).
struct NodePair {
  Index a, b;
};

struct RefitArrays {
  const TreeNode* nodes;
  const ElementList* list;  ///< its positions
  const BoundsTable* vertices;
  BoundsTable* node_bounds;
  BoundsTable* element_bounds;
  TreeCost* costs;
};

/// Refits the nodes [begin, end) in descending order. Their children must be in this range or up to date.
void refit_range(const RefitArrays& arrays, Index begin, Index end);

/// Appends to `out`, for each pair, the overlapping pairs of children, or the pair itself if it is small. Returns the
/// number of node tests.
std::uint64_t expand_pairs(const KdopTree& tree, const PairRules& rules, const std::vector<NodePair>& pairs,
                           std::vector<NodePair>& out);

/// Stack size that traverse() needs.
inline std::size_t stack_length(const KdopTree& tree) { return 6 * static_cast<std::size_t>(tree.depth()) + 8; }

/// Writes every requested pair of elements with overlapping bounds below the node pair; for a == b each unordered pair
/// once, and self pairs if requested. Returns the number of node tests.
std::uint64_t traverse(const KdopTree& tree, const PairRules& rules, NodePair start, NodePair* stack, PairWriter& out);

}  // namespace volccd::detail
