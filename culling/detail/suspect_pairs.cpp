#include <volccd/culling/detail/suspect_pairs.hpp>

#include <bit>

namespace volccd::detail {

void SuspectPairs::update(const Step& step, const StarClasses& classes, Executor& executor) {
  list_.update(step, classes.suspects(), executor, [&](Index a, Index b, Index v) -> ListedPair {
    std::uint32_t common = classes.common_suspects(step.topology, a, b);
    const std::span<const Index> vertices = step.topology.adjacency().vertices(a);
    // A pair that is in several suspect stars is visited once, at the first of these vertices.
    if (common == 0 || vertices[static_cast<std::size_t>(std::countr_zero(common))] != v) return {};
    if (vertices[3] == vertices[0]) common &= 7;  // a triangle repeats its first vertex
    const int count = std::popcount(common);
    const Index other = count == 2 ? vertices[static_cast<std::size_t>(std::bit_width(common)) - 1] : kNone;
    return {true, count <= 2, other};
  });
  set_.clear();
  for (const ElementPair pair : pairs()) set_.insert(pair);
}

}  // namespace volccd::detail
