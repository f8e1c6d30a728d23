#include <volccd/culling/detail/star_table.hpp>

#include <algorithm>
#include <numeric>

namespace volccd::detail {

namespace {

/// Faces of a tetrahedron opposite to vertex i, oriented outward where the volume is positive in VTK's node order.
constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

std::array<Index, 3> face_of(std::span<const Index> vertices, std::size_t i) {
  return {vertices[kFaces[i][0]], vertices[kFaces[i][1]], vertices[kFaces[i][2]]};
}

std::size_t opposite_vertex(std::span<const Index> vertices, const std::array<Index, 3>& face) {
  std::size_t i = 0;
  while (std::find(face.begin(), face.end(), vertices[i]) != face.end()) ++i;
  return i;
}

/// Whether an even number of swaps brings the triangle in ascending order.
bool is_even(const std::array<Index, 3>& t) {
  return ((t[0] > t[1]) ^ (t[0] > t[2]) ^ (t[1] > t[2])) == 0;
}

Index root(std::vector<Index>& parents, Index i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

void join(std::vector<Index>& parents, Index i, Index j) { parents[root(parents, i)] = root(parents, j); }

}  // namespace

void StarTable::set_neighbours(const Topology& topology, Index triangle) {
  const std::array<Index, 3>& face = topology.features().triangle(triangle);
  const std::span<const Index> elements = topology.features().triangle_elements(triangle);
  const auto is_volume = [&](Index o) { return topology.mesh().type(o) == ElementType::tetrahedron; };
  const bool pair = elements.size() == 2 && is_volume(elements[0]) && is_volume(elements[1]);
  std::array<std::size_t, 2> side{};
  std::array<bool, 2> even{};
  for (std::size_t k = 0; k < elements.size(); ++k) {
    if (!is_volume(elements[k])) continue;
    const std::span<const Index> vertices = topology.mesh().vertices(elements[k]);
    const std::size_t i = opposite_vertex(vertices, face);
    neighbours_[elements[k]][i] = {};
    if (pair) side[k] = i, even[k] = is_even(face_of(vertices, i));
  }
  if (!pair) return;
  for (std::size_t k = 0; k < 2; ++k) neighbours_[elements[k]][side[k]] = {elements[1 - k], even[0] != even[1]};
}

/// The link of v is a surface, its triangles (v's tetrahedra) or, where v has triangles only, a curve, its edges. Corners
/// are the pairs of an element and another vertex of it; faces at v join elements, and corners at their ends.
void StarTable::set_star(const Topology& topology, Index v) {
  const std::span<const Index> star = topology.features().vertex_elements(v);
  const Mesh& mesh = topology.mesh();
  rings_.assign(v, {});
  kinds_[v] = star.empty() ? StarKind::unused : StarKind::irregular;
  if (star.empty()) return;
  const ElementType type = mesh.type(star[0]);
  const bool alike = std::all_of(star.begin(), star.end(), [&](Index o) { return mesh.type(o) == type; });
  if (!alike) return;
  open_.clear();
  if (type == ElementType::triangle) {
    for (const Index o : star) {
      const std::span<const Index> t = mesh.vertices(o);
      const std::size_t i = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
      open_.push_back({t[(i + 1) % 3], t[(i + 2) % 3]});
    }
    if (order_ring(v)) kinds_[v] = StarKind::ring;
    return;
  }
  sides_.clear();
  corners_.clear();
  const Index count = static_cast<Index>(star.size());
  for (Index k = 0; k < count; ++k) {
    const std::span<const Index> vertices = mesh.vertices(star[k]);
    for (std::size_t i = 0; i < 4; ++i) {
      if (vertices[i] == v) continue;
      const std::array<Index, 3> face = face_of(vertices, i);
      const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
      const Index a = face[(at + 1) % 3], b = face[(at + 2) % 3];
      const auto corner = [&](Index w) {
        return 4 * k + static_cast<Index>(std::find(vertices.begin(), vertices.end(), w) - vertices.begin());
      };
      sides_.push_back(a < b ? Side{{a, b}, {corner(a), corner(b)}, false} : Side{{b, a}, {corner(b), corner(a)}, true});
      corners_.push_back(vertices[i]);
    }
  }
  std::sort(sides_.begin(), sides_.end());
  std::sort(corners_.begin(), corners_.end());
  const auto others = static_cast<std::size_t>(std::unique(corners_.begin(), corners_.end()) - corners_.begin());
  parents_.resize(5 * std::size_t{count});  // corners, then elements
  std::iota(parents_.begin(), parents_.end(), Index{0});
  for (std::size_t i = 0, n; i < sides_.size(); i += n) {
    for (n = 1; i + n < sides_.size() && sides_[i + n].ends == sides_[i].ends;) ++n;
    if (n > 2) return;
    const Side &x = sides_[i], &y = sides_[i + n - 1];
    if (n == 1) {
      open_.push_back(x.swapped ? std::array{x.ends[1], x.ends[0]} : x.ends);
      continue;
    }
    for (std::size_t end = 0; end < 2; ++end) join(parents_, x.corner[end], y.corner[end]);
    join(parents_, 4 * count + x.corner[0] / 4, 4 * count + y.corner[0] / 4);
  }
  std::size_t parts = 0, fans = 0;
  for (Index k = 0; k < count; ++k) {
    parts += root(parents_, 4 * count + k) == 4 * count + k ? 1 : 0;
    for (Index i = 0; i < 4; ++i)
      fans += mesh.vertices(star[k])[i] != v && root(parents_, 4 * k + i) == 4 * k + i ? 1 : 0;
  }
  if (parts != 1 || fans != others) return;
  if (open_.empty())
    kinds_[v] = StarKind::interior;
  else if (order_ring(v))
    kinds_[v] = StarKind::ring;
}

/// Puts the edges of open_ one after the other; false if they are not one closed ring, oriented alike.
bool StarTable::order_ring(Index v) {
  std::sort(open_.begin(), open_.end());
  ring_.clear();
  Index at = open_[0][0];
  do {
    const auto next = std::lower_bound(open_.begin(), open_.end(), std::array{at, Index{0}});
    if (next == open_.end() || (*next)[0] != at || ring_.size() == open_.size()) return false;
    if (next + 1 != open_.end() && next[1][0] == at) return false;
    ring_.push_back(at);
    at = (*next)[1];
  } while (at != open_[0][0]);
  if (ring_.size() != open_.size()) return false;
  rings_.assign(v, ring_);
  return true;
}

void StarTable::set_boundary(const Topology& topology, Index o) {
  const Mesh& mesh = topology.mesh();
  if (!mesh.is_live(o)) {
    on_boundary_[o] = 0;
    return;
  }
  bool boundary = mesh.type(o) != ElementType::tetrahedron;
  for (const Index v : mesh.vertices(o)) boundary = boundary || kinds_[v] == StarKind::irregular;
  for (const Neighbour& neighbour : neighbours_[o]) boundary = boundary || neighbour.element == kNone;
  on_boundary_[o] = boundary ? 1 : 0;
}

TopologyDelta::Extent StarTable::update(const Topology& topology) {
  const TopologyDelta::Extent changed = delta_.sync(topology);
  const Features& features = topology.features();
  changed_vertices_.clear();
  if (changed == TopologyDelta::Extent::everything) {
    neighbours_.assign(topology.mesh().element_slots(), {});
    on_boundary_.assign(topology.mesh().element_slots(), 0);
    kinds_.assign(features.vertex_slots(), StarKind::unused);
    rings_.clear(features.vertex_slots(), 0);
    for (Index f = 0; f < features.triangle_slots(); ++f) set_neighbours(topology, f);
    for (Index v = 0; v < features.vertex_slots(); ++v) set_star(topology, v);
    for (Index o = 0; o < topology.mesh().element_slots(); ++o) set_boundary(topology, o);
  } else if (changed == TopologyDelta::Extent::edits) {
    neighbours_.resize(topology.mesh().element_slots());
    on_boundary_.resize(topology.mesh().element_slots(), 0);
    kinds_.resize(features.vertex_slots(), StarKind::unused);
    rings_.extend(features.vertex_slots());
    for (const TopologyChange* change : delta_.changes()) {
      const FeatureChange& f = change->features;
      for (const auto* list : {&f.added_triangles, &f.touched_triangles})
        for (const Index triangle : *list) set_neighbours(topology, triangle);
      for (const auto* list : {&f.removed_vertices, &f.added_vertices, &f.touched_vertices})
        changed_vertices_.insert(changed_vertices_.end(), list->begin(), list->end());
    }
    std::sort(changed_vertices_.begin(), changed_vertices_.end());
    changed_vertices_.erase(std::unique(changed_vertices_.begin(), changed_vertices_.end()), changed_vertices_.end());
    for (const Index v : changed_vertices_) set_star(topology, v);
    for (const Index v : changed_vertices_)
      for (const Index o : features.vertex_elements(v)) set_boundary(topology, o);
    for (const Index o : delta_.changed_slots()) set_boundary(topology, o);
    rings_.compact_if_sparse();
  }
  delta_.confirm();
  return changed;
}

std::size_t StarTable::bytes() const {
  return delta_.bytes() + neighbours_.capacity() * sizeof(neighbours_[0]) + on_boundary_.capacity() +
         kinds_.capacity() + rings_.bytes() +
         (changed_vertices_.capacity() + parents_.capacity() + corners_.capacity() + ring_.capacity()) * sizeof(Index) +
         sides_.capacity() * sizeof(Side) + open_.capacity() * sizeof(open_[0]);
}

}  // namespace volccd::detail
