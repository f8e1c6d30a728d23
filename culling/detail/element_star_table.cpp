#include <volccd/culling/detail/element_star_table.hpp>

#include <algorithm>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

bool has_cones(ElementType type) { return !is_shell(type) && !face_stream(type).empty(); }

/// Whether element o has the face with its vertices in opposite order.
bool has_reversed(const Mesh& mesh, Index o, std::span<const Index> face) {
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

constexpr std::size_t kTableElements = 512;

}  // namespace

void ElementStarTable::set_faces(const Topology& topology, Index o) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  faces_[o].fill(Face::none);
  if (!mesh.is_live(o) || !has_cones(mesh.type(o))) return;
  const std::span<const Index> triangles = features.element_triangles(o);
  std::size_t next = 0;  // the triangles have the order of the faces, two for a quad
  visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
    const std::span<const Index> elements = features.triangle_elements(triangles[next]);
    const bool alone =
        elements.size() == 1 && features.triangle_elements(triangles[next + face.size() - 3]).size() == 1;
    const bool pair = elements.size() == 2 && has_reversed(mesh, elements[elements[0] == o ? 1 : 0], face);
    faces_[o][number] = alone ? Face::boundary : pair ? Face::inner : Face::irregular;
    next += face.size() - 2;
  });
}

bool ElementStarTable::find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const {
  const Mesh& mesh = topology.mesh();
  open.clear();
  bool regular = true;
  for (const Index o : topology.features().vertex_elements(v)) {
    if (!has_cones(mesh.type(o))) return false;
    visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
      const std::size_t size = face.size();
      const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
      if (at == size) return;
      regular = regular && faces_[o][number] != Face::irregular;
      if (faces_[o][number] != Face::boundary) return;
      for (std::size_t i = 1; i + 1 < size; ++i) open.push_back({face[(at + i) % size], face[(at + i + 1) % size]});
    });
  }
  return regular;
}

std::vector<RingFace> ElementStarTable::boundary_faces(const Topology& topology) const {
  const Mesh& mesh = topology.mesh();
  std::vector<RingFace> found;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (std::find(faces_[o].begin(), faces_[o].end(), Face::boundary) == faces_[o].end()) continue;
    visit_faces(mesh, o, [&](std::span<const Index> f, std::size_t number) {
      if (faces_[o][number] != Face::boundary) return;
      if (std::none_of(f.begin(), f.end(), [&](Index v) { return kinds_[v] == StarKind::ring; })) return;
      if (f.size() == 3) return found.push_back({{f[0], f[1], f[2]}});
      // Those at the diagonal are tested for all four vertices, the other two for the ends of the other diagonal.
      const auto least = static_cast<std::size_t>(std::min_element(f.begin(), f.end()) - f.begin());
      const auto at = [&](std::size_t i) { return f[(least + i) % 4]; };
      for (std::size_t i = 0; i < 4; i += 2) {
        found.push_back({{at(i), at(i + 1), at(i + 2)}, at(i + 3), 0xf});
        found.push_back({{at(i + 1), at(i + 2), at(i + 3)}, kNone, 0x5});
      }
    });
  }
  return found;
}

TopologyDelta::Extent ElementStarTable::update(const Topology& topology, Executor& executor) {
  const TopologyDelta::Extent changed = sync(topology);
  const Features& features = topology.features();
  faces_.resize(topology.mesh().element_slots());
  if (changed == TopologyDelta::Extent::everything) {
    executor.parallel_for(faces_.size(), kTableElements, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t o = begin; o < end; ++o) set_faces(topology, static_cast<Index>(o));
    });
  } else {
    std::vector<Index> elements = delta_.changed_slots();
    for (const TopologyChange* change : delta_.changes())
      for (const Index triangle : change->features.touched_triangles)
        for (const Index o : features.triangle_elements(triangle)) elements.push_back(o);
    sort_unique(elements);
    for (const Index o : elements) set_faces(topology, o);
  }
  set_kinds(scratch_, executor, [&](Index v, Ring& scratch) {
    return features.vertex_elements(v).empty() ? StarKind::unused : kind_by_sides(topology, v, scratch);
  });
  delta_.confirm();
  return changed;
}

}  // namespace volccd::detail
