#include <volccd/culling/detail/star_table.hpp>

#include <algorithm>
#include <numeric>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

std::size_t opposite_vertex(std::span<const Index> vertices, const std::array<Index, 3>& face) {
  std::size_t i = 0;
  while (std::find(face.begin(), face.end(), vertices[i]) != face.end()) ++i;
  return i;
}

/// Whether an even number of swaps sorts the vertices of the triangle.
bool is_even(const std::array<Index, 3>& t) { return ((t[0] > t[1]) ^ (t[0] > t[2]) ^ (t[1] > t[2])) == 0; }

Index root(std::vector<Index>& parents, Index i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

}  // namespace

bool Ring::order() {
  std::sort(open.begin(), open.end());
  vertices.clear();
  Index at = open[0][0];
  do {
    const auto next = std::lower_bound(open.begin(), open.end(), std::array{at, Index{0}});
    if (next == open.end() || (*next)[0] != at || vertices.size() == open.size()) return false;
    if (next + 1 != open.end() && next[1][0] == at) return false;
    vertices.push_back(at);
    at = (*next)[1];
  } while (at != open[0][0]);
  return vertices.size() == open.size();
}

TopologyDelta::Extent StarKinds::sync(const Topology& topology) {
  const TopologyDelta::Extent changed = delta_.sync(topology);
  kinds_.resize(topology.features().vertex_slots(), StarKind::unused);
  changed_vertices_.clear();
  for (const TopologyChange* change : delta_.changes()) {
    const FeatureChange& f = change->features;
    for (const auto* list : {&f.removed_vertices, &f.added_vertices, &f.touched_vertices})
      changed_vertices_.insert(changed_vertices_.end(), list->begin(), list->end());
  }
  sort_unique(changed_vertices_);
  if (changed == TopologyDelta::Extent::everything) {
    changed_vertices_.resize(kinds_.size());
    std::iota(changed_vertices_.begin(), changed_vertices_.end(), Index{0});
  }
  return changed;
}

std::span<const Index> StarKinds::ring(const Topology& topology, Index v, Ring& scratch) const {
  if (kinds_[v] != StarKind::ring) return {};
  find_open(topology, v, scratch.open);
  scratch.order();
  return scratch.vertices;
}

StarKind StarKinds::kind_by_sides(const Topology& topology, Index v, Ring& scratch) const {
  if (!find_open(topology, v, scratch.open)) return StarKind::irregular;
  if (scratch.open.empty()) return StarKind::interior;
  return scratch.order() ? StarKind::ring : StarKind::irregular;
}

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
    neighbours_[elements[k]][i] = {kNone, elements.size() > 1};
    if (pair) side[k] = i, even[k] = is_even(face_of(vertices, i));
  }
  if (!pair) return;
  for (std::size_t k = 0; k < 2; ++k) neighbours_[elements[k]][side[k]] = {elements[1 - k], even[0] != even[1]};
}

/// Whether the link of v, whose triangles correspond to the tetrahedra at v, is a connected surface that is also
/// connected around each of its vertices. A corner is a pair of a tetrahedron and another vertex of it; a face at v
/// connects two tetrahedra, and their corners at the other vertices of the face.
bool StarTable::joins_up(const Topology& topology, Index v, Scratch& scratch) const {
  const std::span<const Index> star = topology.features().vertex_elements(v);
  const Mesh& mesh = topology.mesh();
  const Index count = static_cast<Index>(star.size());
  scratch.places.resize(mesh.element_slots());
  scratch.corners.resize(mesh.vertex_count(), kNone);
  for (Index k = 0; k < count; ++k) scratch.places[star[k]] = k;
  std::vector<Index>& parents = scratch.parents;
  parents.resize(5 * std::size_t{count});  // corners, then elements
  std::iota(parents.begin(), parents.end(), Index{0});
  const auto join = [&](Index i, Index j) {
    i = root(parents, i), j = root(parents, j);
    parents[i] = j;
    return i == j ? Index{0} : Index{1};  // by how much the number of parts decreases
  };
  bool shared = false;  // whether more than two elements share a face
  Index parts = count, fans = 0, others = 0;
  for (Index k = 0; k < count; ++k) {
    const std::span<const Index> vertices = mesh.vertices(star[k]);
    for (Index i = 0; i < 4; ++i) {
      if (vertices[i] == v) continue;
      others += scratch.corners[vertices[i]] == kNone ? 1 : 0;
      scratch.corners[vertices[i]] = k;
      ++fans;
      const Neighbour& across = neighbours_[star[k]][i];
      shared = shared || (across.element == kNone && across.opposite);
      if (across.element == kNone) continue;
      const Index other = scratch.places[across.element];
      if (other < k) continue;
      const std::span<const Index> of_other = mesh.vertices(across.element);
      for (Index j = 0; j < 4; ++j) {
        if (j == i || vertices[j] == v) continue;
        const auto at = static_cast<Index>(std::find(of_other.begin(), of_other.end(), vertices[j]) - of_other.begin());
        fans -= join(4 * k + j, 4 * other + at);
      }
      parts -= join(4 * count + k, 4 * count + other);
    }
  }
  for (const Index o : star)
    for (const Index w : mesh.vertices(o)) scratch.corners[w] = kNone;
  return !shared && parts == 1 && fans == others;
}

/// Calls visit(face) for the boundary faces of an element.
template <class Visit>
void StarTable::visit_boundary(const Mesh& mesh, Index o, Visit&& visit) const {
  const std::span<const Index> v = mesh.vertices(o);
  if (v.size() == 3) return visit(std::array{v[0], v[1], v[2]});
  for (std::size_t i = 0; i < 4; ++i)
    if (neighbours_[o][i].element == kNone) visit(face_of(v, i));
}

bool StarTable::find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const {
  open.clear();
  for (const Index o : topology.features().vertex_elements(v))
    visit_boundary(topology.mesh(), o, [&](const std::array<Index, 3>& face) {
      const auto i = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
      if (i < 3) open.push_back({face[(i + 1) % 3], face[(i + 2) % 3]});
    });
  return true;
}

StarKind StarTable::kind_of(const Topology& topology, Index v, Scratch& scratch) const {
  const std::span<const Index> star = topology.features().vertex_elements(v);
  if (star.empty()) return StarKind::unused;
  const ElementType type = topology.mesh().type(star[0]);
  const bool alike = std::all_of(star.begin(), star.end(), [&](Index o) { return topology.mesh().type(o) == type; });
  if (!alike) return StarKind::irregular;
  if (type == ElementType::tetrahedron && !joins_up(topology, v, scratch)) return StarKind::irregular;
  return kind_by_sides(topology, v, scratch.ring);
}

std::uint8_t StarTable::boundary_part_of(const Mesh& mesh, Index o) const {
  if (!mesh.is_live(o)) return ElementSubset::kNoPart;
  const std::span<const Index> vertices = mesh.vertices(o);
  const bool irregular =
      std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return kinds_[v] == StarKind::irregular; });
  if (mesh.type(o) != ElementType::tetrahedron || irregular) return ElementSubset::kWhole;
  std::uint8_t part = ElementSubset::kNoPart;
  for (unsigned i = 0; i < 4; ++i) {
    if (neighbours_[o][i].element != kNone) continue;
    part = part == ElementSubset::kNoPart ? static_cast<std::uint8_t>(0xf & ~(1u << i)) : ElementSubset::kWhole;
  }
  return part;
}

StarTable::Fit StarTable::fit_of(const Mesh& mesh, Index o) const {
  if (!mesh.is_live(o) || mesh.type(o) != ElementType::tetrahedron) return Fit::other;
  for (const Neighbour& across : neighbours_[o])
    if (across.element != kNone && !across.opposite) return Fit::folded;
  return shares_a_face_with_several(o) ? Fit::other : Fit::regular;
}

void StarTable::set_element(const Topology& topology, Index o) {
  boundary_parts_[o] = boundary_part_of(topology.mesh(), o);
  fits_[o] = fit_of(topology.mesh(), o);
}

std::vector<RingFace> StarTable::boundary_faces(const Topology& topology) const {
  const Mesh& mesh = topology.mesh();
  std::vector<RingFace> faces;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o))
      visit_boundary(mesh, o, [&](const std::array<Index, 3>& face) {
        if (std::any_of(face.begin(), face.end(), [&](Index v) { return kinds_[v] == StarKind::ring; }))
          faces.push_back({face});
      });
  return faces;
}

TopologyDelta::Extent StarTable::update(const Topology& topology, Executor& executor) {
  const TopologyDelta::Extent changed = sync(topology);
  const bool everything = changed == TopologyDelta::Extent::everything;
  const Features& features = topology.features();
  const Index slots = topology.mesh().element_slots();
  if (everything) neighbours_.clear();
  neighbours_.resize(slots);
  boundary_parts_.resize(slots, 0);
  fits_.resize(slots, Fit::other);
  for (Index f = 0; everything && f < features.triangle_slots(); ++f) set_neighbours(topology, f);
  for (const TopologyChange* change : delta_.changes())
    for (const auto* list : {&change->features.added_triangles, &change->features.touched_triangles})
      for (const Index triangle : *list) set_neighbours(topology, triangle);
  set_kinds(scratch_, executor, [&](Index v, Scratch& scratch) { return kind_of(topology, v, scratch); });
  if (everything) {
    for (Index o = 0; o < slots; ++o) set_element(topology, o);
  } else {
    for (const Index v : changed_vertices())
      for (const Index o : features.vertex_elements(v)) set_element(topology, o);
    for (const Index o : delta_.changed_slots()) set_element(topology, o);
  }
  delta_.confirm();
  return changed;
}

}  // namespace volccd::detail
