#include <volccd/simulation/topology/element_cutting.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <tuple>

#include <fmt/format.h>

namespace volccd::simulation {

namespace {

/// Lengths below this count as zero, relative to the edge or to the length of the cut; positions are accurate to about
/// 1e-15 of it.
constexpr double kCutTolerance = 1e-9;

struct DividedEdge {
  std::array<Index, 2> edge;  ///< ascending
  Index vertex;               ///< the new vertex on the edge
};

/// A tetrahedron after subdivision, which is the parent itself if it is not divided.
struct Piece {
  std::array<Index, 4> vertices;
  Index parent;
};

/// A triangle of surface vertices on the piece, ascending.
struct PieceFace {
  std::array<Index, 3> vertices;
  Index piece;
  bool operator<(const PieceFace& other) const {
    return std::tie(vertices, piece) < std::tie(other.vertices, other.piece);
  }
};

/// Union-find over the pieces around a vertex, by their position in the star.
class Groups {
 public:
  void reset(std::size_t n) {
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  /// The smallest member of i's group.
  std::size_t find(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void unite(std::size_t i, std::size_t j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::size_t> parent_;
};

class Cutter {
 public:
  Cutter(const Topology& topology, std::span<const Vec3> positions, const Cut& cut, double depth)
      : topology_(topology), mesh_(topology.mesh()), x_(positions), cut_(cut), depth_(depth) {
    proposal_.shapes_of_parents = false;
  }

  TopologyProposal run(double snap) {
    collect_edges();
    assign_sides(snap);
    divide_edges();
    subdivide();
    separate();
    write();
    return std::move(proposal_);
  }

 private:
  void collect_edges();
  void assign_sides(double snap);
  void divide_edges();
  void check_tetrahedra(std::array<Index, 2> edge) const;
  void subdivide();
  void separate();
  std::vector<PieceFace> cut_faces() const;
  void separate_star(Index v, std::span<const Index> star, std::span<const PieceFace> faces);
  void join_star(Index v, std::span<const Index> star, std::span<const PieceFace> faces);
  void write();

  bool in_object(Index o) const { return mesh_.object(o) == cut_.object; }
  double distance(Index v) const { return (x_[v] - cut_.point).dot(cut_.normal); }
  bool is_covered(const Vec3& p) const;
  bool on_surface(Index v) const { return v >= mesh_.vertex_count() || (side_[v] == 0 && is_covered(x_[v])); }
  int side(Index v) const { return v >= mesh_.vertex_count() ? 0 : side_[v]; }
  int side(const Piece& piece) const;

  const Topology& topology_;
  const Mesh& mesh_;
  std::span<const Vec3> x_;
  const Cut& cut_;
  double depth_;

  std::vector<std::array<Index, 2>> edges_;                        ///< of the object, ascending
  std::vector<signed char> side_;                                  ///< by vertex: side of the plane, -1, 0 or 1
  std::vector<DividedEdge> divided_;                               ///< ascending
  std::vector<Piece> pieces_;                                      ///< of all tetrahedra of the object, by parent
  std::vector<std::pair<Index, std::pair<Index, Index>>> copies_;  ///< (piece, (vertex, its copy))
  TopologyProposal proposal_;

  // Scratch of part_star.
  Groups groups_;
  std::vector<std::tuple<Index, Index, std::size_t>>
      star_faces_;  ///< (other vertices of a face at v, place in the star)
};

bool Cutter::is_covered(const Vec3& p) const {
  const double t = (p - cut_.point).dot(cut_.direction), tolerance = kCutTolerance * cut_.length;
  return t >= -tolerance && t <= depth_ + tolerance;
}

void Cutter::collect_edges() {
  for (Index o = 0; o < mesh_.element_slots(); ++o)
    if (mesh_.is_live(o) && in_object(o) && mesh_.type(o) != ElementType::tetrahedron)
      throw InputError("cut", "elements", mesh_.element_id(o), "only tetrahedra can be cut");
  const Features& features = topology_.features();
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (std::ranges::any_of(features.edge_elements(e), [&](Index o) { return in_object(o); }))
      edges_.push_back(features.edge(e));
  std::sort(edges_.begin(), edges_.end());  // slots depend on the history of changes
}

void Cutter::assign_sides(double snap) {
  side_.assign(mesh_.vertex_count(), 0);
  for (const auto& edge : edges_)
    for (Index v : edge) side_[v] = distance(v) > 0 ? 1 : -1;
  // Uses the distances, not the sides, which change here: the result must not depend on the order of the edges.
  for (const auto& [v, w] : edges_) {
    const double dv = distance(v), dw = distance(w), noise = kCutTolerance * (x_[w] - x_[v]).norm();
    const bool crosses = (dv > 0) != (dw > 0);
    const double span = std::abs(dv) + std::abs(dw);
    if (std::abs(dv) <= noise || (crosses && std::abs(dv) < snap * span)) side_[v] = 0;
    if (std::abs(dw) <= noise || (crosses && std::abs(dw) < snap * span)) side_[w] = 0;
  }
}

void Cutter::divide_edges() {
  for (const auto& [v, w] : edges_) {
    if (side_[v] * side_[w] >= 0) continue;
    const double dv = std::abs(distance(v)), dw = std::abs(distance(w)), s = dv / (dv + dw);
    if (!is_covered((1 - s) * x_[v] + s * x_[w])) continue;
    check_tetrahedra({v, w});
    divided_.push_back({{v, w}, add_copy(proposal_, mesh_, v)});
    proposal_.new_vertices.back() = {{v, w}, {1 - s, s}};
  }
}

void Cutter::check_tetrahedra(std::array<Index, 2> edge) const {
  const Features& features = topology_.features();
  for (Index o : features.edge_elements(features.find_edge(edge[0], edge[1])))
    if (!in_object(o))
      throw InputError("cut", "elements", mesh_.element_id(o), "shares a divided edge, but belongs to another object");
}

/// Bisects each tetrahedron by its divided edges, one after the other in their order. The triangulation of a face then
/// depends on its own edges and that order only, so that both elements at it agree.
void Cutter::subdivide() {
  const auto divider = [&](Index v, Index w) -> const DividedEdge* {
    const std::array<Index, 2> edge{std::min(v, w), std::max(v, w)};
    const auto found = std::ranges::lower_bound(divided_, edge, {}, &DividedEdge::edge);
    return found != divided_.end() && found->edge == edge ? &*found : nullptr;
  };
  std::vector<const DividedEdge*> dividers;
  for (Index o = 0; o < mesh_.element_slots(); ++o) {
    if (!mesh_.is_live(o) || !in_object(o)) continue;
    const std::span<const Index> v = mesh_.vertices(o);
    dividers.clear();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (side_[v[i]] * side_[v[j]] < 0)
          if (const DividedEdge* found = divider(v[i], v[j])) dividers.push_back(found);
    std::sort(dividers.begin(), dividers.end());

    const std::size_t begin = pieces_.size();
    pieces_.push_back({{v[0], v[1], v[2], v[3]}, o});
    for (const DividedEdge* divided : dividers)
      for (std::size_t i = begin, end = pieces_.size(); i < end; ++i) {
        auto& half = pieces_[i].vertices;
        const auto a = std::ranges::find(half, divided->edge[0]), b = std::ranges::find(half, divided->edge[1]);
        if (a == half.end() || b == half.end()) continue;
        Piece other = pieces_[i];
        *a = divided->vertex;
        other.vertices[static_cast<std::size_t>(b - half.begin())] = divided->vertex;
        pieces_.push_back(other);
      }
  }
}

/// Side of a piece that does not cross the plane. If all its vertices count as on the plane, the side on which most of
/// it lies.
int Cutter::side(const Piece& piece) const {
  double sum = 0;
  for (Index v : piece.vertices) {
    if (side(v) != 0) return side(v);
    if (v < mesh_.vertex_count()) sum += distance(v);
  }
  return sum > 0 ? 1 : -1;
}

/// Faces of the pieces that lie between the two sides, behind the blade's edge. Each has two entries, one for each
/// side.
std::vector<PieceFace> Cutter::cut_faces() const {
  std::vector<PieceFace> faces;
  for (Index p = 0; p < pieces_.size(); ++p)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      PieceFace face{{}, p};
      std::size_t n = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (i != opposite && on_surface(pieces_[p].vertices[i])) face.vertices[n++] = pieces_[p].vertices[i];
      if (n < 3) continue;
      std::sort(face.vertices.begin(), face.vertices.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  std::vector<PieceFace> parted;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    const PieceFace &f = faces[i - 1], &g = faces[i];
    if (f.vertices == g.vertices && side(pieces_[f.piece]) != side(pieces_[g.piece]))
      parted.insert(parted.end(), {f, g});
  }
  return parted;
}

void Cutter::separate() {
  const std::vector<PieceFace> faces = cut_faces();
  std::vector<std::pair<Index, std::size_t>> at;  // (vertex, its cut face)
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (Index v : faces[f].vertices) at.emplace_back(v, f);
  std::sort(at.begin(), at.end());

  std::vector<std::pair<Index, Index>> stars;  // (vertex, its piece)
  for (Index p = 0; p < pieces_.size(); ++p)
    for (Index v : pieces_[p].vertices)
      if (on_surface(v)) stars.emplace_back(v, p);
  std::sort(stars.begin(), stars.end());

  std::vector<PieceFace> faces_at;
  std::vector<Index> star;
  auto next = stars.begin();
  for (std::size_t i = 0; i < at.size();) {
    const Index v = at[i].first;
    faces_at.clear();
    for (; i < at.size() && at[i].first == v; ++i) faces_at.push_back(faces[at[i].second]);
    while (next->first != v) ++next;
    star.clear();
    for (; next != stars.end() && next->first == v; ++next) star.push_back(next->second);
    separate_star(v, star, faces_at);
  }
}

/// Groups the pieces around v that are connected by faces at v that are not cut.
void Cutter::join_star(Index v, std::span<const Index> star, std::span<const PieceFace> faces) {
  star_faces_.clear();
  for (std::size_t i = 0; i < star.size(); ++i) {
    std::array<Index, 3> others{};
    std::remove_copy(pieces_[star[i]].vertices.begin(), pieces_[star[i]].vertices.end(), others.begin(), v);
    std::sort(others.begin(), others.end());
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
      star_faces_.emplace_back(others[static_cast<std::size_t>(a)], others[static_cast<std::size_t>(b)], i);
  }
  std::sort(star_faces_.begin(), star_faces_.end());
  groups_.reset(star.size());
  for (std::size_t k = 1; k < star_faces_.size(); ++k) {
    const auto& [a, b, i] = star_faces_[k - 1];
    const auto& [c, d, j] = star_faces_[k];
    if (a != c || b != d) continue;
    std::array<Index, 3> face{v, a, b};
    std::sort(face.begin(), face.end());
    if (std::ranges::find(faces, face, &PieceFace::vertices) == faces.end()) groups_.unite(i, j);
  }
}

/// Gives a copy of v to each group of pieces that has been cut off, on the positive side. A group that reaches from one
/// side of the cut to the other goes around its front and keeps v.
void Cutter::separate_star(Index v, std::span<const Index> star, std::span<const PieceFace> faces) {
  join_star(v, star, faces);
  std::vector<int> sides(star.size(), 0);  // by group: bit 0, it has a cut face as the negative side; bit 1, positive
  for (const PieceFace& face : faces) {
    const auto place = static_cast<std::size_t>(std::ranges::lower_bound(star, face.piece) - star.begin());
    sides[groups_.find(place)] |= side(pieces_[face.piece]) > 0 ? 2 : 1;
  }
  for (std::size_t group = 0; group < star.size(); ++group) {
    if (sides[group] != 2) continue;
    const Index copy = add_copy(proposal_, mesh_, v);
    for (std::size_t i = 0; i < star.size(); ++i)
      if (groups_.find(i) == group) copies_.push_back({star[i], {v, copy}});
  }
}

void Cutter::write() {
  for (const auto& [p, change] : copies_) std::ranges::replace(pieces_[p].vertices, change.first, change.second);
  std::int64_t last_id = 0;
  for (Index o = 0; o < mesh_.element_slots(); ++o)
    if (mesh_.is_live(o)) last_id = std::max(last_id, mesh_.element_id(o));

  for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
    const Index parent = pieces_[begin].parent;
    while (end < pieces_.size() && pieces_[end].parent == parent) ++end;
    if (end - begin == 1 && std::ranges::equal(pieces_[begin].vertices, mesh_.vertices(parent))) continue;
    proposal_.edit.removed.push_back(parent);
    for (std::size_t p = begin; p < end; ++p) {
      ElementSpec element = element_spec(mesh_, parent);
      element.vertices.assign(pieces_[p].vertices.begin(), pieces_[p].vertices.end());
      if (p != begin) element.id = ++last_id;
      proposal_.edit.added.push_back(std::move(element));
      proposal_.parents.push_back(parent);
    }
  }
}

}  // namespace

double covered_depth(const Cut& cut, double time) {
  return std::clamp((time - cut.begin) * cut.speed, 0.0, cut.length);
}

TopologyProposal propose_cut(const Topology& topology, std::span<const Vec3> positions, const Cut& cut, double depth,
                             double snap) {
  if (!(snap >= 0 && snap < 0.5)) throw ConfigError(fmt::format("cut: snap is {}, not in [0, 0.5)", snap));
  assert(positions.size() >= topology.mesh().vertex_count());
  if (!(depth > 0)) return {};
  return Cutter(topology, positions, cut, depth).run(snap);
}

}  // namespace volccd::simulation
