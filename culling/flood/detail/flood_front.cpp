#include <volccd/culling/flood/detail/flood_front.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <volccd/numerics/certified_sign.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kGrain = 4096;

bool is_volume(const Mesh& mesh, Index o) { return mesh.type(o) == ElementType::tetrahedron; }

/// Whether no tetrahedron at v is outer as a whole.
bool has_faces_alone(const Step& step, const PartTable& parts, Index v) {
  const std::span<const Index> star = step.features().vertex_elements(v);
  return std::all_of(star.begin(), star.end(),
                     [&](Index o) { return !is_volume(step.mesh(), o) || parts.has_inside(o); });
}

/// The vertices of `part` that belong to the outer part of o, if there is one, as bits.
std::uint32_t common_part_vertices(const PartTable& parts, std::span<const Index> part, Index o) {
  if (!parts.has_part(o)) return 0;
  const std::span<const Index> other = parts.part(o);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < part.size(); ++i)
    if (std::find(other.begin(), other.end(), part[i]) != other.end()) bits |= 1u << i;
  return bits;
}

}  // namespace

std::span<const OuterNeighbour> OuterNeighbours::of(const Step& step, const StarTable& table, const PartTable& parts,
                                                    Index o) {
  auto& [begin, end] = ranges_[o];
  if (begin == kNone) {
    begin = static_cast<Index>(list_.size());
    const std::span<const Index> part = parts.part(o);
    for (const Index v : part) {
      const bool by_edges = table.kind(v) == StarKind::ring && has_faces_alone(step, parts, v);
      for (const Index next : step.features().vertex_elements(v)) {
        const std::uint32_t common = common_part_vertices(parts, part, next);
        const bool listed = std::any_of(list_.begin() + begin, list_.end(),
                                        [&](const OuterNeighbour& other) { return other.element == next; });
        if (next != o && !listed && std::popcount(common) >= (by_edges ? 2 : 1)) list_.push_back({next, common});
      }
    }
    end = static_cast<Index>(list_.size());
  }
  return std::span(list_).subspan(begin, end - begin);
}

void FloodFront::propose(Index a, Index b) {
  if (a == b || step_.topology.adjacency().adjacent(a, b)) return;
  const ElementPair pair{std::min(a, b), std::max(a, b)};
  if (seen_.insert(pair)) out_.push_back(pair);
}

void FloodFront::propose_across_faces(Index of, Index other) {
  const Features& features = step_.features();
  if (!is_volume(step_.mesh(), of)) return;
  for (const Index face : features.element_triangles(of))
    for (const Index across : features.triangle_elements(face))
      if (across != of && parts_.has_inside(across)) propose(across, other);
}

void FloodFront::propose_neighbours(ElementPair pair) {
  propose_across_faces(pair.a, pair.b);
  propose_across_faces(pair.b, pair.a);
}

/// Whether at t = 0 all vertices of b, except those of a face of a, are beyond that face, also if vertices are
/// displaced by half of the separation. Then a and b have no common points except the convex hull of their common
/// vertices.
bool FloodFront::beyond_a_face_at_start(Index a, Index b) const {
  if (!is_volume(step_.mesh(), a)) return false;
  const std::span<const Index> of_a = step_.mesh().vertices(a), of_b = step_.mesh().vertices(b);
  for (std::size_t i = 0; i < 4; ++i) {
    const Index x = of_a[i == 0 ? 1 : 0], y = of_a[i <= 1 ? 2 : 1], z = of_a[i <= 2 ? 3 : 2];
    const Vec3 at = step_.motion.point(x, 0);
    const Vec3 e = step_.motion.point(y, 0) - at, f = step_.motion.point(z, 0) - at;
    const auto side = [&](Index v) {
      return CertifiedDeterminant(e, f, step_.motion.point(v, 0) - at, step_.separation);
    };
    const CertifiedDeterminant own = side(of_a[i]);
    if (!own.positive() && !own.negative()) continue;
    const bool beyond = std::all_of(of_b.begin(), of_b.end(), [&](Index v) {
      return v == x || v == y || v == z || (own.positive() ? side(v).negative() : side(v).positive());
    });
    if (beyond) return true;
  }
  return false;
}

/// A coordinate plus (outward = 1) or minus (-1) the separation. The sum has one rounding, for which the last term
/// compensates.
double FloodFront::moved(double coordinate, int outward) const {
  const double sum = coordinate + outward * step_.separation;
  return step_.separation > 0 ? sum + outward * 2 * kUnitRoundoff * std::abs(sum) : coordinate;
}

/// Finds, for each vertex of the mesh, the vertices among along_x that have its first coordinate, as a range; in the
/// range of a vertex without any, both ends say where it would be.
void FloodFront::rank_vertices(StartScratch& scratch, Executor& executor) const {
  const auto& along_x = scratch.along_x;
  scratch.ranks.resize(step_.motion.vertex_count());
  executor.parallel_for(scratch.ranks.size(), kGrain, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t v = first; v < last; ++v) {
      const double x = step_.motion.at(static_cast<Index>(v))[0], low = moved(x, -1), high = moved(x, 1);
      const auto begin =
          std::partition_point(along_x.begin(), along_x.end(), [&](const auto& p) { return p.first < low; });
      const auto end = std::partition_point(begin, along_x.end(), [&](const auto& p) { return p.first <= high; });
      scratch.ranks[v] = {static_cast<Index>(begin - along_x.begin()), static_cast<Index>(end - along_x.begin())};
    }
  });
}

/// Proposes pairs with the elements whose boxes, with the separation around them, contain one of the vertices. Most
/// elements lie between two of these vertices in the order of the first coordinates.
void FloodFront::propose_containing(std::span<const Index> vertices, StartScratch& scratch, Executor& executor) {
  const Mesh& mesh = step_.mesh();
  auto& along_x = scratch.along_x;
  along_x.clear();
  for (const Index v : vertices) along_x.emplace_back(step_.motion.at(v)[0], v);
  std::sort(along_x.begin(), along_x.end());
  rank_vertices(scratch, executor);
  scratch.contained.resize(executor.workers());
  for (auto& list : scratch.contained) list.clear();
  executor.parallel_for(mesh.element_slots(), kGrain, [&](std::size_t first, std::size_t last, unsigned w) {
    for (Index o = static_cast<Index>(first); o < last; ++o) {
      if (!mesh.is_live(o) || !parts_.has_inside(o)) continue;
      const std::span<const Index> corners = step_.topology.adjacency().vertices(o);
      const auto packed = [&](std::size_t i) { return std::bit_cast<std::uint64_t>(scratch.ranks[corners[i]]); };
      const bool between_the_same = packed(0) == packed(1) && packed(0) == packed(2) && packed(0) == packed(3);
      if (between_the_same && scratch.ranks[corners[0]][0] == scratch.ranks[corners[0]][1]) continue;
      Index begin = kNone, end = 0;
      for (const Index corner : corners) {
        begin = std::min(begin, scratch.ranks[corner][0]);
        end = std::max(end, scratch.ranks[corner][1]);
      }
      for (Index i = begin; i < end; ++i)
        if (box_contains(o, along_x[i].second)) scratch.contained[w].push_back({o, along_x[i].second});
    }
  });
  auto& all = scratch.contained[0];
  for (std::size_t w = 1; w < scratch.contained.size(); ++w)
    all.insert(all.end(), scratch.contained[w].begin(), scratch.contained[w].end());
  std::sort(all.begin(), all.end());
  for (const auto& [o, v] : all)
    for (const Index element : step_.features().vertex_elements(v))
      if (parts_.has_part(element) && std::ranges::count(parts_.part(element), v) > 0) propose(element, o);
}

/// Whether the box of o, with the separation around it, contains the vertex. Pre: it does so along the first axis.
bool FloodFront::box_contains(Index o, Index v) const {
  const std::span<const Index> corners = step_.topology.adjacency().vertices(o);
  for (const int axis : {1, 2}) {
    const auto at = [&](std::size_t i) { return step_.motion.at(corners[i])[axis]; };
    const auto [low, high] = std::minmax({at(0), at(1), at(2), at(3)});
    if (step_.motion.at(v)[axis] < moved(low, -1) || step_.motion.at(v)[axis] > moved(high, 1)) return false;
  }
  return true;
}

void FloodFront::propose_at_start(Index outer_element, Index other, StartScratch& scratch) {
  if (!parts_.has_part(outer_element)) return;
  propose_across_faces(other, outer_element);
  if (!parts_.has_inside(other)) return;
  const std::array<std::uint8_t, 4> sides = sides_at_start(box_at_start(other), parts_.part(outer_element));
  for (const OuterNeighbour& next : scratch.neighbours.of(step_, table_, parts_, outer_element)) {
    std::uint8_t beyond = 0xff;  // the sides of the box that all common vertices are beyond
    for (std::size_t i = 0; i < 4; ++i)
      if ((next.common >> i & 1) != 0) beyond &= sides[i];
    if (beyond == 0) propose(next.element, other);
  }
}

void FloodFront::propose_neighbours_at_start(ElementPair pair, StartScratch& scratch) {
  propose_at_start(pair.a, pair.b, scratch);
  propose_at_start(pair.b, pair.a, scratch);
}

/// The box of an element at t = 0, with the separation around it.
Eigen::AlignedBox3d FloodFront::box_at_start(Index o) const {
  Eigen::AlignedBox3d box;
  for (const Index v : step_.mesh().vertices(o)) box.extend(step_.motion.point(v, 0));
  for (int axis = 0; axis < 3; ++axis) {
    box.min()[axis] = moved(box.min()[axis], -1);
    box.max()[axis] = moved(box.max()[axis], 1);
  }
  return box;
}

/// For each vertex, the sides of the box that it is beyond at t = 0, as bits.
std::array<std::uint8_t, 4> FloodFront::sides_at_start(const Eigen::AlignedBox3d& box,
                                                       std::span<const Index> vertices) const {
  std::array<std::uint8_t, 4> sides{};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double* const at = step_.motion.at(vertices[i]);
    for (int axis = 0; axis < 3; ++axis) {
      const int bits = (at[axis] < box.min()[axis] ? 1 : 0) | (at[axis] > box.max()[axis] ? 2 : 0);
      sides[i] |= static_cast<std::uint8_t>(bits << (2 * axis));
    }
  }
  return sides;
}

}  // namespace volccd::detail
