#include <volccd/mesh/oriented_boundary.hpp>

#include <span>

#include <volccd/mesh/features.hpp>

namespace volccd {

std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o) {
  std::vector<std::array<Index, 3>> triangles;
  const auto add = [&](Index a, Index b, Index c) { triangles.push_back({a, b, c}); };
  if (mesh.type(o) == ElementType::polytope)
    visit_faces(mesh.polytope_faces(o), [&](std::span<const Index> face) { detail::visit_fan(face, add); });
  else  // the triangles of fixed types are oriented as their faces
    visit_boundary(
        mesh, o, EdgeSet::triangulated, [](Index, Index) {}, add);
  return triangles;
}

}  // namespace volccd
