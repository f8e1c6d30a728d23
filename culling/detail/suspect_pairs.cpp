#include <volccd/culling/detail/suspect_pairs.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <volccd/culling/detail/volume_signs.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kSuspectGrain = 16;

/// Two simplices that have one vertex in common. Their other vertices relative to it, those of the first simplex
/// negated, at all control points: if all of them have positive dot products with one direction, the simplices lie on
/// different sides of the moving plane through the vertex that is perpendicular to this direction.
class SharedCorner {
 public:
  SharedCorner(const Motion& motion, std::span<const Index> a, std::span<const Index> b, Index common) {
    const double* const at = motion.at(common);
    const auto add = [&](std::span<const Index> vertices, double sign) {
      for (const Index v : vertices) {
        if (v == common) continue;
        const double* const x = motion.at(v);
        for (int c = 0; c < motion.control_points(); ++c)
          vectors_[size_++] = sign * Vec3(x[3 * c] - at[3 * c], x[3 * c + 1] - at[3 * c + 1], x[3 * c + 2] - at[3 * c + 2]);
      }
    };
    add(a, -1);
    add(b, 1);
  }

  /// Searches for such a direction: approaches the point of the convex hull of the vectors that is nearest to the
  /// origin (Frank and Wolfe 1956).
  bool has_plane() const {
    constexpr int kMostRounds = 8;
    Vec3 direction = Vec3::Zero();
    for (std::size_t i = 0; i < size_; ++i) direction += vectors_[i];
    direction /= static_cast<double>(size_);
    for (int round = 0; round < kMostRounds; ++round) {
      std::size_t lowest = 0;
      double least = direction.dot(vectors_[0]);
      for (std::size_t i = 1; i < size_; ++i)
        if (const double product = direction.dot(vectors_[i]); product < least) least = product, lowest = i;
      if (least > 0) return all_positive(direction);
      const Vec3 way = vectors_[lowest] - direction;
      const double share = -direction.dot(way) / way.squaredNorm();
      if (!(share > 0)) return false;
      direction += std::min(share, 1.0) * way;
    }
    return false;
  }

 private:
  /// Whether all dot products are certainly positive. Each has a rounded difference, a product and two sums.
  bool all_positive(const Vec3& direction) const {
    const Vec3 magnitude = direction.cwiseAbs();
    return std::all_of(vectors_.begin(), vectors_.begin() + static_cast<std::ptrdiff_t>(size_), [&](const Vec3& v) {
      return direction.dot(v) > 8 * kUnitRoundoff * magnitude.dot(v.cwiseAbs()) + kLeast;
    });
  }

  static constexpr double kLeast = 0x1p-1000;  ///< more than what underflows in a dot product

  std::array<Vec3, 18> vectors_;
  std::size_t size_ = 0;
};

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
  for (const auto& [u, v] : {std::pair{a[0], a[1]}, std::pair{b[0], b[1]}, std::pair{a[0], b[0]},
                             std::pair{a[0], b[1]}, std::pair{a[1], b[0]}, std::pair{a[1], b[1]}})
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
  for (std::size_t i = 0; i < star.size(); ++i)
    for (std::size_t j = i; j < star.size(); ++j) {
      const ElementPair pair{star[i], star[j]};
      if (classes.first_common_suspect(step.topology, pair.a, pair.b) != v) continue;
      const std::span<const Index> a = mesh.vertices(pair.a), b = mesh.vertices(pair.b);
      const int common = pair.a == pair.b ? 4 : std::popcount(StarClasses::common_vertices(step.topology, pair.a, pair.b));
      if (common == 2 && a.size() == 4 && b.size() == 4)
        worker.at_edges.push_back(pair);
      else if (common != 1 || !SharedCorner(step.motion, a, b, v).has_plane())
        worker.found.push_back(pair);
    }
}

void SuspectPairs::decide_at_edges(const Step& step, Worker& worker) {
  worker.tetrahedra.clear();
  for (const ElementPair pair : worker.at_edges) append_volumes(step.topology, pair, worker.tetrahedra);
  worker.signs.resize(worker.tetrahedra.size());
  volume_signs(step.motion, worker.tetrahedra, worker.signs.data());
  for (std::size_t i = 0; i < worker.at_edges.size(); ++i)
    if (!separated_by_a_face(worker.signs.data() + i * kEdgeVolumes)) worker.found.push_back(worker.at_edges[i]);
  worker.at_edges.clear();
}

void SuspectPairs::update(const Step& step, const StarClasses& classes, Executor& executor) {
  workers_.resize(executor.workers());
  const std::vector<Index>& suspects = classes.suspects();
  executor.parallel_for(suspects.size(), kSuspectGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i) at_vertex(step, classes, suspects[i], workers_[w]);
    decide_at_edges(step, workers_[w]);
  });
  pairs_.clear();
  set_.clear();
  for (Worker& worker : workers_) {
    pairs_.insert(pairs_.end(), worker.found.begin(), worker.found.end());
    worker.found.clear();
  }
  for (const ElementPair pair : pairs_) set_.insert(pair);
}

std::size_t SuspectPairs::bytes() const {
  std::size_t sum = pairs_.capacity() * sizeof(ElementPair) + set_.bytes();
  for (const Worker& worker : workers_)
    sum += sizeof worker + (worker.found.capacity() + worker.at_edges.capacity()) * sizeof(ElementPair) +
           worker.tetrahedra.capacity() * sizeof(worker.tetrahedra[0]) + worker.signs.capacity();
  return sum;
}

}  // namespace volccd::detail
