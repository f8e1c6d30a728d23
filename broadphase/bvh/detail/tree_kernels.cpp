#include <volccd/broadphase/bvh/detail/tree_kernels.hpp>

#include <bit>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/bvh/detail/tree_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <volccd/broadphase/detail/bounds-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Squared half perimeter of a bound along x, y, z; 0 for an empty bound.
template <int kWidth>
HWY_INLINE double size_of(const float* row) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += static_cast<double>(row[kWidth + i]) - static_cast<double>(row[i]);
  return sum >= 0 ? sum * sum : 0;
}

/// `first`: the first position of the range of nodes; another thread may reorder those before it.
template <int kWidth>
void refit_leaf(const RefitArrays& t, Index node, Index first) {
  constexpr Index ahead = 12;  // leaves are processed in descending order; their rows are prefetched this far ahead
  const Index begin = t.nodes[node].begin, end = t.nodes[node].end;
  double elements = 0;
  for (Index p = begin; p < end; ++p) {
    if (p >= first + ahead && t.list->slot(p - ahead) != kNone)
      for (const Index v : t.list->vertices(p - ahead)) hwy::Prefetch(t.vertices->row(v));
    if (p >= first + 2 * ahead && t.list->slot(p - 2 * ahead) != kNone)
      hwy::Prefetch(t.list->vertices(p - 2 * ahead).data());
    float* const row = t.element_bounds->row(p);
    if (t.list->slot(p) == kNone) {
      make_empty<kWidth>(row);
      continue;
    }
    unite_vertices<kWidth>(t.vertices->row(0), t.list->vertices(p), row);
    elements += size_of<kWidth>(row);
  }
  float* const bound = t.node_bounds->row(node);
  const float* const rows = t.element_bounds->row(begin);
  unite_rows<kWidth>(
      end - begin, [&](std::size_t r) HWY_ATTR { return rows + r * 2 * kWidth; }, bound);
  t.costs[node] = {size_of<kWidth>(bound), elements};
}

void refit_kernel(const RefitArrays& t, Index begin, Index end) {
  with_width(t.vertices->width(), [&](auto width) {
    for (Index node = end; node-- > begin;) {
      const Index left = node + 1, right = t.nodes[node].right;
      if (right == 0) {
        refit_leaf<width>(t, node, t.nodes[begin].begin);
        continue;
      }
      const float* const halves[] = {t.node_bounds->row(left), t.node_bounds->row(right)};
      unite_rows<width>(
          2, [&](std::size_t i) HWY_ATTR { return halves[i]; }, t.node_bounds->row(node));
      t.costs[node] = {size_of<width>(t.node_bounds->row(node)) + t.costs[left].nodes + t.costs[right].nodes,
                       t.costs[left].elements + t.costs[right].elements};
    }
  });
}

template <int kWidth>
class Traversal {
 public:
  Traversal(const KdopTree& tree, const PairRules& rules)
      : nodes_(tree.nodes().data()),
        slots_(tree.slots().data()),
        adjacent_(tree.adjacent_leaves()),
        node_rows_(tree.node_bounds().row(0)),
        element_rows_(tree.element_bounds().row(0)),
        rules_(rules) {}

  std::uint64_t tests() const { return tests_; }

  /// Calls push(a, b) for the pairs of children of a pair. Pre: the pair does not consist of two leaves, or of a leaf
  /// and itself.
  template <class Push>
  HWY_INLINE void descend(NodePair pair, Push&& push) {
    const TreeNode &a = nodes_[pair.a], &b = nodes_[pair.b];
    const Index al = pair.a + 1, bl = pair.b + 1;
    if (pair.a == pair.b) {
      if (may_include(al, al)) push(al, al);
      if (may_include(a.right, a.right)) push(a.right, a.right);
      test(al, a.right, push);
    } else if (a.right == 0) {
      test(pair.a, bl, push);
      test(pair.a, b.right, push);
    } else if (b.right == 0) {
      test(al, pair.b, push);
      test(a.right, pair.b, push);
    } else {
      test(al, bl, push);
      test(al, b.right, push);
      test(a.right, bl, push);
      test(a.right, b.right, push);
    }
  }

  bool is_leaf(Index node) const { return nodes_[node].right == 0; }

  void run(NodePair start, NodePair* stack, PairWriter& out) {
    std::size_t top = 0;
    stack[top++] = start;
    const auto push = [&](Index a, Index b) { stack[top++] = {a, b}; };
    while (top > 0) {
      const NodePair pair = stack[--top];
      if (!is_leaf(pair.a) || !is_leaf(pair.b))
        descend(pair, push);
      else if (rules_.adjacency && known(pair))
        known_leaves(pair, out);
      else
        leaves(pair, out);
    }
  }

  HWY_INLINE bool may_include(Index a, Index b) const { return rules_.may_include(nodes_[a].key, nodes_[b].key); }

 private:
  static constexpr Index kLanes = 4;

  HWY_INLINE const float* node_row(Index i) const { return node_rows_ + i * std::size_t{2 * kWidth}; }
  HWY_INLINE const float* element_row(Index i) const { return element_rows_ + i * std::size_t{2 * kWidth}; }

  template <class Push>
  HWY_INLINE void test(Index a, Index b, Push&& push) {
    ++tests_;
    if (overlap<kWidth>(node_row(a), node_row(b)) && may_include(a, b)) push(a, b);
  }

  HWY_INLINE bool known(NodePair pair) const {
    return adjacent_.has(nodes_[pair.a].begin) && adjacent_.has(nodes_[pair.b].begin);
  }

  /// The mask of adjacent pairs of two leaves in the table.
  HWY_INLINE std::uint64_t adjacent_pairs(Index a, Index b) const {
    const AdjacentLeaves::Row row = adjacent_.row(a);
    const hn::CappedTag<std::uint32_t, AdjacentLeaves::kPadding> d;
    const auto leaf = hn::Set(d, b);
    for (std::size_t k = 0; k < row.size; k += hn::Lanes(d)) {
      const auto at = hn::FindFirstTrue(d, hn::Eq(leaf, hn::LoadU(d, row.leaves + k)));
      if (at >= 0) return row.masks[k + static_cast<std::size_t>(at)];
    }
    return 0;
  }

  /// The mask of all pairs of elements of two leaves; for a leaf and itself, each unordered pair of two elements once.
  static std::uint64_t all_pairs(const TreeNode& a, const TreeNode& b, bool itself) {
    constexpr std::uint64_t rows = 0x0101010101010101, after = 0x80c0e0f0f8fcfe;
    const std::uint64_t row = (std::uint64_t{1} << (b.end - b.begin)) - 1;
    const std::uint64_t all = rows * row & ~std::uint64_t{0} >> 8 * (AdjacentLeaves::kMaskRow - (a.end - a.begin));
    return itself ? all & after : all;
  }

  /// leaves() for two leaves in the table of adjacent leaves. Most such pairs have nothing to write.
  HWY_INLINE void known_leaves(NodePair pair, PairWriter& out) {
    const TreeNode &a = nodes_[pair.a], &b = nodes_[pair.b];
    std::uint64_t wanted = all_pairs(a, b, pair.a == pair.b) & ~adjacent_pairs(a.begin, b.begin);
    if (wanted == 0) return;
    const bool mixed = rules_.keys && (a.key == FilterKeys::kMixed || b.key == FilterKeys::kMixed);
    std::uint64_t hits = 0;
    for (Index i = a.begin; i < a.end; ++i) {
      if (!overlap<kWidth>(element_row(i), node_row(pair.b))) continue;
      for (Index j = b.begin; j < b.end; j += kLanes)
        hits |= std::uint64_t{overlaps(i, j)} << (AdjacentLeaves::kMaskRow * (i - a.begin) + (j - b.begin));
    }
    hits &= wanted;
    if (hits == 0) return;
    ElementPair* next = out.room();
    for (Index i = a.begin; i < a.end; ++i, hits >>= AdjacentLeaves::kMaskRow)
      for (Index j = b.begin; j < b.end; j += kLanes) {
        unsigned row = static_cast<unsigned>(hits >> (j - b.begin)) & ((1u << kLanes) - 1);
        if (mixed) row = allowed(row, i, j);
        next = emit(row, i, j, next);
      }
    out.written(next);
  }

  /// Tests each element of the first leaf that overlaps the second against four elements of the latter at a time.
  HWY_INLINE void leaves(NodePair pair, PairWriter& out) {
    const TreeNode &a = nodes_[pair.a], &b = nodes_[pair.b];
    const bool itself = pair.a == pair.b;
    const bool mixed = rules_.keys && (a.key == FilterKeys::kMixed || b.key == FilterKeys::kMixed);
    ElementPair* next = out.room();
    for (Index i = a.begin; i < a.end; ++i) {
      if (!overlap<kWidth>(element_row(i), node_row(pair.b))) continue;
      for (Index j = b.begin; j < b.end; j += kLanes) {
        unsigned hits = overlaps(i, j) & ((1u << std::min(b.end - j, kLanes)) - 1);
        if (itself) hits = after(hits, i, j);
        if (rules_.adjacency) hits = not_adjacent(hits, i, j);
        if (mixed) hits = allowed(hits, i, j);
        next = emit(hits, i, j, next);
      }
    }
    out.written(next);
  }

  /// Bit l is set if element i overlaps element j + l.
  HWY_INLINE unsigned overlaps(Index i, Index j) const {
    const float* const row = element_row(i);
    unsigned hits = 0;
    for (Index l = 0; l < kLanes; ++l) hits |= unsigned{overlap<kWidth>(row, element_row(j + l))} << l;
    return hits;
  }

  /// Within one leaf: keeps the bits of elements after i, and that of i itself if it is live and self pairs are
  /// requested.
  HWY_INLINE unsigned after(unsigned hits, Index i, Index j) const {
    const Index first = rules_.self_pairs && slots_[i] != kNone ? i : i + 1;
    if (first <= j) return hits;
    return first - j >= kLanes ? 0 : hits & (~0u << (first - j));
  }

  /// The bits of pairs that are not adjacent, and of those that the filter allows.
  HWY_INLINE unsigned not_adjacent(unsigned hits, Index i, Index j) const {
    return keep(hits, i, j, [&](Index a, Index b) { return !rules_.adjacency->adjacent(a, b); });
  }
  HWY_NOINLINE unsigned allowed(unsigned hits, Index i, Index j) const {
    const FilterKeys& keys = *rules_.keys;
    return keep(hits, i, j, [&](Index a, Index b) { return keys.allowed(keys.key(a), keys.key(b)); });
  }
  template <class F>
  HWY_INLINE unsigned keep(unsigned hits, Index i, Index j, F&& f) const {
    unsigned kept = 0;
    for (unsigned rest = hits; rest != 0; rest &= rest - 1)
      if (f(slots_[i], slots_[j + static_cast<Index>(std::countr_zero(rest))])) kept |= rest & -rest;
    return kept;
  }

  /// Writes the pairs whose bits are set, without a branch: every pair is written to the next position, which advances
  /// only if the bit is set.
  HWY_INLINE ElementPair* emit(unsigned hits, Index i, Index j, ElementPair* next) const {
#if HWY_TARGET == HWY_SCALAR
    for (Index l = 0; l < kLanes; ++l) {
      *next = {std::min(slots_[i], slots_[j + l]), std::max(slots_[i], slots_[j + l])};
      next += hits >> l & 1;
    }
#else
    const hn::CappedTag<std::uint32_t, kLanes> d;
    const hn::RepartitionToWide<decltype(d)> pair;
    const auto a = hn::Set(d, slots_[i]), b = hn::LoadU(d, slots_ + j);
    const auto low = hn::Min(a, b), high = hn::Max(a, b);
    const auto first = hn::BitCast(pair, hn::InterleaveLower(d, low, high));
    const auto second = hn::BitCast(pair, hn::InterleaveUpper(d, low, high));
    const auto put = [&](auto lanes, unsigned bit) {
      hn::StoreU(lanes, pair, reinterpret_cast<std::uint64_t*>(next));
      next += hits >> bit & 1;
    };
    put(first, 0);
    put(hn::InterleaveUpper(pair, first, first), 1);
    put(second, 2);
    put(hn::InterleaveUpper(pair, second, second), 3);
#endif
    return next;
  }

  const TreeNode* const nodes_;
  const Index* const slots_;
  const AdjacentLeaves& adjacent_;
  const float* const node_rows_;
  const float* const element_rows_;
  const PairRules rules_;
  std::uint64_t tests_ = 0;
};

/// Calls f with a Traversal for the width of the tree, and returns the number of its node tests.
template <class F>
std::uint64_t with_traversal(const KdopTree& tree, const PairRules& rules, F&& f) {
  return with_width(tree.node_bounds().width(), [&](auto width) {
    Traversal<width> traversal(tree, rules);
    f(traversal);
    return traversal.tests();
  });
}

std::uint64_t expand_kernel(const KdopTree& tree, const PairRules& rules, const std::vector<NodePair>& pairs,
                            std::vector<NodePair>& out) {
  constexpr Index small = 64;  // limit for the number of elements of both nodes together
  return with_traversal(tree, rules, [&](auto& traversal) {
    for (const NodePair pair : pairs)
      if (tree.nodes()[pair.a].size() + tree.nodes()[pair.b].size() <= small)
        out.push_back(pair);
      else
        traversal.descend(pair, [&](Index a, Index b) { out.push_back({a, b}); });
  });
}

std::uint64_t traverse_kernel(const KdopTree& tree, const PairRules& rules, NodePair start, NodePair* stack,
                              PairWriter& out) {
  return with_traversal(tree, rules, [&](auto& traversal) { traversal.run(start, stack, out); });
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(refit_kernel);
HWY_EXPORT(expand_kernel);
HWY_EXPORT(traverse_kernel);

void refit_range(const RefitArrays& arrays, Index begin, Index end) {
  HWY_DYNAMIC_DISPATCH(refit_kernel)(arrays, begin, end);
}

std::uint64_t expand_pairs(const KdopTree& tree, const PairRules& rules, const std::vector<NodePair>& pairs,
                           std::vector<NodePair>& out) {
  return HWY_DYNAMIC_DISPATCH(expand_kernel)(tree, rules, pairs, out);
}

std::uint64_t traverse(const KdopTree& tree, const PairRules& rules, NodePair start, NodePair* stack, PairWriter& out) {
  return HWY_DYNAMIC_DISPATCH(traverse_kernel)(tree, rules, start, stack, out);
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
