#include <volccd/culling/detail/suspect_pairs.hpp>

#include <bit>

namespace volccd::detail {

namespace {

constexpr std::size_t kSuspectGrain = 16;

}  // namespace

void SuspectPairs::at_vertex(const Step& step, const StarClasses& classes, Index v, Worker& worker) {
  const std::span<const Index> star = step.features().vertex_elements(v);
  worker.corners.begin();
  for (std::size_t i = 0; i < star.size(); ++i)
    for (std::size_t j = i; j < star.size(); ++j) {
      std::uint32_t common = classes.common_suspects(step.topology, star[i], star[j]);
      const std::span<const Index> vertices = step.topology.adjacency().vertices(star[i]);
      // A pair that is in several suspect stars is visited once, at the first of these vertices.
      if (common == 0 || vertices[static_cast<std::size_t>(std::countr_zero(common))] != v) continue;
      if (vertices[3] == vertices[0]) common &= 7;  // a triangle repeats its first vertex
      const int count = std::popcount(common);
      const Index other = count == 2 ? vertices[static_cast<std::size_t>(std::bit_width(common)) - 1] : kNone;
      if (count > 2 || !worker.corners.add(step, v, i, j, other)) worker.found.push_back({star[i], star[j]});
    }
  worker.corners.decide(step, v, [&](Index a, Index b) { worker.found.push_back({a, b}); });
}

void SuspectPairs::update(const Step& step, const StarClasses& classes, Executor& executor) {
  workers_.resize(executor.workers());
  for (Worker& worker : workers_) worker.found.clear();
  const std::vector<Index>& suspects = classes.suspects();
  executor.parallel_for(suspects.size(), kSuspectGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i) at_vertex(step, classes, suspects[i], workers_[w]);
  });
  pairs_.clear();
  set_.clear();
  for (const Worker& worker : workers_) pairs_.insert(pairs_.end(), worker.found.begin(), worker.found.end());
  for (const ElementPair pair : pairs_) set_.insert(pair);
}

std::size_t SuspectPairs::bytes() const {
  std::size_t sum = pairs_.capacity() * sizeof(ElementPair) + set_.bytes();
  for (const Worker& worker : workers_)
    sum += sizeof worker + worker.found.capacity() * sizeof(ElementPair) + worker.corners.bytes();
  return sum;
}

}  // namespace volccd::detail
