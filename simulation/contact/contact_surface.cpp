#include <volccd/simulation/contact/contact_surface.hpp>

#include <algorithm>

namespace volccd::simulation {

ContactSurface::ContactSurface(const Topology& collision, ContactFeatures features, Index copies)
    : features_(features), copies_(copies) {
  mark(collision);
  if (features == ContactFeatures::surface) note_first(collision);
}

void ContactSurface::update(const Topology& collision, std::span<const Index> origins) {
  origins_.assign(origins.begin(), origins.end());
  mark(collision);
}

Index ContactSurface::origin(Index vertex) const {
  const Index v = vertex / copies_;
  return v < origins_.size() ? copies_ * origins_[v] + vertex % copies_ : vertex;
}

std::array<Index, 3> ContactSurface::origin_of(const std::array<Index, 3>& triangle) const {
  std::array<Index, 3> result = {origin(triangle[0]), origin(triangle[1]), origin(triangle[2])};
  std::sort(result.begin(), result.end());
  return result;
}

/// Stores the triangles of the initial surface. For faces with more than three vertices it stores all triangles into
/// which they could be divided, because a vertex split may change the diagonal.
void ContactSurface::note_first(const Topology& collision) {
  const Mesh& mesh = collision.mesh();
  const Features& features = collision.features();
  std::vector<std::array<Index, 3>> triangles;
  const auto add_face = [&](std::span<const Index> face) {
    triangles.clear();
    bool outside = false;
    for (std::size_t i = 0; i < face.size(); ++i)
      for (std::size_t j = i + 1; j < face.size(); ++j)
        for (std::size_t k = j + 1; k < face.size(); ++k) {
          const Index f = features.find_triangle(face[i], face[j], face[k]);
          outside |= f != kNone && triangle_[f] != 0;
          triangles.push_back({face[i], face[j], face[k]});
          std::sort(triangles.back().begin(), triangles.back().end());
        }
    if (outside) first_.insert(first_.end(), triangles.begin(), triangles.end());
  };
  std::vector<Index> face;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    visit_faces(face_stream(mesh.type(o)), [&](std::span<const std::uint8_t> numbers) {  // no polytopes in a simulation
      face.clear();
      for (const std::uint8_t i : numbers) face.push_back(mesh.vertices(o)[i]);
      add_face(face);
    });
  }
  std::sort(first_.begin(), first_.end());
}

void ContactSurface::mark(const Topology& collision) {
  const Features& features = collision.features();
  vertex_.assign(features.vertex_slots(), 0);
  edge_.assign(features.edge_slots(), 0);
  triangle_.assign(features.triangle_slots(), 0);
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    if (features.triangle_elements(f).size() != 1) continue;
    if (!first_.empty() && !std::binary_search(first_.begin(), first_.end(), origin_of(features.triangle(f)))) continue;
    triangle_[f] = 1;
    const auto& v = features.triangle(f);
    for (Index i : v) vertex_[i] = 1;
    for (std::size_t i = 0; i < 3; ++i)
      if (const Index e = features.find_edge(v[i], v[(i + 1) % 3]); e != kNone) edge_[e] = 1;
  }
}

}  // namespace volccd::simulation
