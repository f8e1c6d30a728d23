#include <volccd/culling/detail/suspect_pairs.hpp>

#include <algorithm>
#include <bit>
#include <utility>

#include <volccd/culling/detail/volume_signs.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kSuspectGrain = 16;

/// Vertices of a that b has, if `common`, or else those that b does not have. Pre: a and b are tetrahedra with two
/// common vertices.
std::array<Index, 2> two_of(const Topology& topology, Index a, Index b, bool common) {
  const std::uint32_t bits = StarClasses::common_vertices(topology, a, b);
  std::array<Index, 2> chosen{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (((bits >> i & 1) != 0) == common) chosen[count++] = topology.adjacency().vertices(a)[i];
  return chosen;
}

/// The volumes that decide about two tetrahedra with a common edge: those of the edge and two of the four other
/// vertices a0, a1, b0, b1.
enum EdgeVolume : std::size_t { a0_a1, b0_b1, a0_b0, a0_b1, a1_b0, a1_b1, kEdgeVolumes };

void append_volumes(const Topology& topology, ElementPair pair, std::vector<std::array<Index, 4>>& out) {
  const auto edge = two_of(topology, pair.a, pair.b, true);
  const auto a = two_of(topology, pair.a, pair.b, false), b = two_of(topology, pair.b, pair.a, false);
  for (const auto& [u, v] : {std::pair{a[0], a[1]}, std::pair{b[0], b[1]}, std::pair{a[0], b[0]}, std::pair{a[0], b[1]},
                             std::pair{a[1], b[0]}, std::pair{a[1], b[1]}})
    out.push_back({edge[0], edge[1], u, v});
}

/// Whether one of the four faces at the edge has its own tetrahedron on one side and the other one on the other side.
bool separated_by_a_face(const std::int8_t* sign) {
  const auto all = [](int x, int y, int z) { return x != 0 && x == y && y == z; };
  return all(sign[a0_b0], sign[a0_b1], -sign[a0_a1]) || all(sign[a1_b0], sign[a1_b1], sign[a0_a1]) ||
         all(sign[a0_b0], sign[a1_b0], sign[b0_b1]) || all(sign[a0_b1], sign[a1_b1], -sign[b0_b1]);
}

}  // namespace

void SuspectPairs::at_vertex(const Step& step, const StarClasses& classes, Index v, Worker& worker) {
  const Mesh& mesh = step.mesh();
  const std::span<const Index> star = step.features().vertex_elements(v);
  worker.corners.begin();
  for (std::size_t i = 0; i < star.size(); ++i)
    for (std::size_t j = i; j < star.size(); ++j) {
      const Index a = star[i], b = star[j];
      if (classes.first_common_suspect(step.topology, a, b) != v) continue;
      const bool volumes = mesh.type(a) == ElementType::tetrahedron && mesh.type(b) == ElementType::tetrahedron;
      const int common = a == b ? 4 : std::popcount(StarClasses::common_vertices(step.topology, a, b));
      if (common == 1 && worker.corners.add(step, star, i, j)) continue;
      if (common == 2 && volumes)
        worker.edge_pairs.push_back({a, b});
      else
        worker.found.push_back({a, b});
    }
  worker.corners.decide(step, star, v, [&](Index a, Index b) { worker.found.push_back({a, b}); });
}

void SuspectPairs::decide_at_edges(const Step& step, Worker& worker) {
  worker.tetrahedra.clear();
  for (const ElementPair pair : worker.edge_pairs) append_volumes(step.topology, pair, worker.tetrahedra);
  worker.signs.resize(worker.tetrahedra.size());
  volume_signs(step, worker.tetrahedra, worker.signs.data());
  for (std::size_t i = 0; i < worker.edge_pairs.size(); ++i)
    if (!separated_by_a_face(worker.signs.data() + i * kEdgeVolumes)) worker.found.push_back(worker.edge_pairs[i]);
  worker.edge_pairs.clear();
}

void SuspectPairs::update(const Step& step, const StarClasses& classes, Executor& executor) {
  workers_.resize(executor.workers());
  for (Worker& worker : workers_) {  // an interrupted update may have left pairs
    worker.found.clear();
    worker.edge_pairs.clear();
  }
  const std::vector<Index>& suspects = classes.suspects();
  executor.parallel_for(suspects.size(), kSuspectGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i) at_vertex(step, classes, suspects[i], workers_[w]);
    decide_at_edges(step, workers_[w]);
  });
  pairs_.clear();
  set_.clear();
  for (const Worker& worker : workers_) pairs_.insert(pairs_.end(), worker.found.begin(), worker.found.end());
  for (const ElementPair pair : pairs_) set_.insert(pair);
}

std::size_t SuspectPairs::bytes() const {
  std::size_t sum = pairs_.capacity() * sizeof(ElementPair) + set_.bytes();
  for (const Worker& worker : workers_)
    sum += sizeof worker + (worker.found.capacity() + worker.edge_pairs.capacity()) * sizeof(ElementPair) +
           worker.tetrahedra.capacity() * sizeof(worker.tetrahedra[0]) + worker.signs.capacity() +
           worker.corners.bytes();
  return sum;
}

}  // namespace volccd::detail
