#include <volccd/culling/stars/star_table.hpp>

#include <algorithm>
#include <numeric>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kTableElements = 512, kTableVertices = 256;

/// Whether the type has a face stream.
bool has_faces(ElementType type) { return type != ElementType::polytope && type != ElementType::none; }

/// Whether an even number of swaps sorts the vertices of the triangle.
bool is_even(std::span<const Index> t) { return ((t[0] > t[1]) ^ (t[0] > t[2]) ^ (t[1] > t[2])) == 0; }

/// Pre: the tetrahedron has the three vertices of the face.
bool tetrahedron_has_reversed(std::span<const Index> vertices, std::span<const Index> face) {
  std::size_t i = 0;
  while (vertices[i] == face[0] || vertices[i] == face[1] || vertices[i] == face[2]) ++i;
  return is_even(face) != is_even(face_opposite(vertices, i));
}

/// Whether element o, which has a triangle of the face, has the face with its vertices in opposite order.
bool has_reversed(const Mesh& mesh, Index o, std::span<const Index> face) {
  if (is_shell(mesh.type(o))) return false;
  if (mesh.type(o) == ElementType::tetrahedron)
    return face.size() == 3 && tetrahedron_has_reversed(mesh.vertices(o), face);
  bool found = false;
  const std::size_t size = face.size();
  visit_faces(mesh, o, [&](std::span<const Index> other, std::size_t) {
    const auto at = static_cast<std::size_t>(std::find(other.begin(), other.end(), face[0]) - other.begin());
    if (other.size() != size || at == size) return;
    bool reversed = true;
    for (std::size_t i = 1; i < size; ++i) reversed = reversed && face[i] == other[(at + size - i) % size];
    found = found || reversed;
  });
  return found;
}

/// Whether the sides are one closed ring with consistent orientation. Sorts them. Pre: there is at least one side.
bool is_closed_ring(RingSides& sides) {
  std::sort(sides.begin(), sides.end());
  std::size_t count = 0;
  Index at = sides[0][0];
  do {
    const auto next = std::lower_bound(sides.begin(), sides.end(), std::array{at, Index{0}});
    if (next == sides.end() || (*next)[0] != at || count == sides.size()) return false;
    if (next + 1 != sides.end() && next[1][0] == at) return false;
    ++count;
    at = (*next)[1];
  } while (at != sides[0][0]);
  return count == sides.size();
}

/// Whether a face is not an inner one.
bool has_open_faces(const std::array<FaceKind, 6>& faces) {
  return std::any_of(faces.begin(), faces.end(),
                     [](FaceKind face) { return face == FaceKind::boundary || face == FaceKind::irregular; });
}

}  // namespace

void StarTable::set_faces(const Topology& topology, Index o) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  faces_[o].fill(FaceKind::none);
  if (!mesh.is_live(o) || !has_faces(mesh.type(o))) return;
  if (is_shell(mesh.type(o))) {
    faces_[o][0] = FaceKind::boundary;
    return;
  }
  const std::span<const Index> triangles = features.element_triangles(o);
  std::size_t next = 0;  // the triangles have the order of the faces, two for a quad
  visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
    const std::span<const Index> elements = features.triangle_elements(triangles[next]);
    const bool alone =
        elements.size() == 1 && features.triangle_elements(triangles[next + face.size() - 3]).size() == 1;
    const bool pair = elements.size() == 2 && has_reversed(mesh, elements[elements[0] == o ? 1 : 0], face);
    faces_[o][number] = alone ? FaceKind::boundary : pair ? FaceKind::inner : FaceKind::irregular;
    next += face.size() - 2;
  });
}

/// Finds the sides of the boundary faces at v that do not contain v, with the orientation of the faces. Returns false
/// if the star is irregular.
bool StarTable::find_sides(const Topology& topology, Index v, RingSides& sides) const {
  const Mesh& mesh = topology.mesh();
  const std::span<const Index> star = topology.features().vertex_elements(v);
  const bool shells = is_shell(mesh.type(star[0]));
  sides.clear();
  bool regular = true;
  for (const Index o : star) {
    if (!has_faces(mesh.type(o)) || is_shell(mesh.type(o)) != shells) return false;
    if (!has_open_faces(faces_[o])) continue;
    visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
      const std::size_t size = face.size();
      const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
      if (at == size) return;
      regular = regular && faces_[o][number] != FaceKind::irregular;
      if (faces_[o][number] != FaceKind::boundary) return;
      for (std::size_t i = 1; i + 1 < size; ++i) sides.push_back({face[(at + i) % size], face[(at + i + 1) % size]});
    });
  }
  return regular;
}

StarKind StarTable::kind_of(const Topology& topology, Index v, RingSides& scratch) const {
  if (topology.features().vertex_elements(v).empty()) return StarKind::unused;
  if (!find_sides(topology, v, scratch)) return StarKind::irregular;
  if (scratch.empty()) return StarKind::interior;
  return is_closed_ring(scratch) ? StarKind::ring : StarKind::irregular;
}

const RingSides& StarTable::ring(const Topology& topology, Index v, RingSides& scratch) const {
  scratch.clear();
  if (kinds_[v] == StarKind::ring) find_sides(topology, v, scratch);
  return scratch;
}

bool StarTable::share_inner_face(const Mesh& mesh, Index a, Index b) const {
  const std::span<const Index> of_b = mesh.vertices(b);
  bool inner = false;
  visit_faces(mesh, a, [&](std::span<const Index> face, std::size_t number) {
    const bool common = std::all_of(face.begin(), face.end(),
                                    [&](Index v) { return std::find(of_b.begin(), of_b.end(), v) != of_b.end(); });
    inner = inner || (common && faces_[a][number] == FaceKind::inner);
  });
  return inner;
}

std::vector<RingFace> StarTable::boundary_faces(const Topology& topology, std::span<const std::uint8_t> judged) const {
  const Mesh& mesh = topology.mesh();
  std::vector<RingFace> found;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!has_open_faces(faces_[o])) continue;
    visit_faces(mesh, o, [&](std::span<const Index> f, std::size_t number) {
      if (faces_[o][number] != FaceKind::boundary) return;
      const auto is_wanted = [&](Index v) { return kinds_[v] == StarKind::ring && judged[v] != 0; };
      if (std::none_of(f.begin(), f.end(), is_wanted)) return;
      if (f.size() == 3) return found.push_back({{f[0], f[1], f[2]}});
      // Those at the diagonal are tested for all four vertices, the other two for the ends of the other diagonal.
      const auto min = static_cast<std::size_t>(std::min_element(f.begin(), f.end()) - f.begin());
      const auto at = [&](std::size_t i) { return f[(min + i) % 4]; };
      for (std::size_t i = 0; i < 4; i += 2) {
        found.push_back({{at(i), at(i + 1), at(i + 2)}, at(i + 3), 0xf});
        found.push_back({{at(i + 1), at(i + 2), at(i + 3)}, kNone, 0x5});
      }
    });
  }
  return found;
}

void StarTable::sync_vertices(const Topology& topology, TopologyDelta::Extent changed) {
  kinds_.resize(topology.features().vertex_slots(), StarKind::unused);
  changed_vertices_.clear();
  if (changed == TopologyDelta::Extent::everything) {
    changed_vertices_.resize(kinds_.size());
    std::iota(changed_vertices_.begin(), changed_vertices_.end(), Index{0});
    return;
  }
  for (const TopologyChange* change : delta_.changes()) {
    const FeatureChange& f = change->features;
    for (const auto* list : {&f.removed_vertices, &f.added_vertices, &f.touched_vertices})
      changed_vertices_.insert(changed_vertices_.end(), list->begin(), list->end());
  }
  sort_unique(changed_vertices_);
}

TopologyDelta::Extent StarTable::update(const Topology& topology, Executor& executor) {
  const TopologyDelta::Extent changed = delta_.sync(topology);
  sync_vertices(topology, changed);
  faces_.resize(topology.mesh().element_slots());
  if (changed == TopologyDelta::Extent::everything) {
    executor.parallel_for(faces_.size(), kTableElements, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t o = begin; o < end; ++o) set_faces(topology, static_cast<Index>(o));
    });
  } else {
    std::vector<Index> elements = delta_.changed_slots();
    for (const TopologyChange* change : delta_.changes())
      for (const Index triangle : change->features.touched_triangles)
        for (const Index o : topology.features().triangle_elements(triangle)) elements.push_back(o);
    sort_unique(elements);
    for (const Index o : elements) set_faces(topology, o);
  }
  scratch_.resize(executor.workers());
  executor.parallel_for(changed_vertices_.size(), kTableVertices, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i)
      kinds_[changed_vertices_[i]] = kind_of(topology, changed_vertices_[i], scratch_[w]);
  });
  delta_.confirm();
  return changed;
}

}  // namespace volccd::detail
