// The inner loops of KdopTree, dispatched to the instruction set of the machine.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/broadphase/detail/kdop_tree.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>

namespace volccd::detail {

/// Two nodes whose bounds overlap, or one node against itself (a == b).
struct NodePair {
  Index a, b;
};

struct RefitArrays {
  const TreeNode* nodes;
  const ElementList* list;
  const BoundsTable* vertices;
  BoundsTable* node_bounds;
  BoundsTable* element_bounds;
  TreeCost* costs;
};

/// Refits the nodes [begin, end) from the last to the first; children of these nodes are among them or up to date.
void refit_range(const RefitArrays& arrays, Index begin, Index end);

/// Pairs of nodes that a traversal of the whole tree starts from: the roots with themselves and with each other.
std::uint64_t start_pairs(const KdopTree& tree, const PairRules& rules, std::vector<NodePair>& out);

/// Appends to `out` what follows from each pair: overlapping pairs of children, or the pair itself if it is small.
/// Returns the number of node tests.
std::uint64_t expand_pairs(const KdopTree& tree, const PairRules& rules, const std::vector<NodePair>& pairs,
                           std::vector<NodePair>& out);

/// Length of the stack that traverse() needs.
inline std::size_t stack_length(const KdopTree& tree) { return 6 * static_cast<std::size_t>(tree.depth()) + 8; }

/// Writes every pair of elements below the node pair whose bounds overlap and that the rules want; below a == b each
/// unordered pair once, and each element with itself if that is wanted. Returns the number of node tests.
std::uint64_t traverse(const KdopTree& tree, const PairRules& rules, NodePair start, NodePair* stack,
                       PairWriter& out);

}  // namespace volccd::detail
