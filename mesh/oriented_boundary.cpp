#include <volccd/mesh/oriented_boundary.hpp>

#include <algorithm>
#include <span>

#include <volccd/mesh/features.hpp>

namespace volccd {

std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o) {
  std::vector<std::array<Index, 3>> triangles;
  const auto add = [&](Index a, Index b, Index c) { triangles.push_back({a, b, c}); };
  if (mesh.type(o) != ElementType::polytope) {  // the triangles of fixed types are oriented as their faces
    visit_boundary(
        mesh, o, EdgeSet::triangulated, [](Index, Index) {}, add);
    return triangles;
  }
  visit_faces(mesh.polytope_faces(o), [&](std::span<const Index> stored) {
    std::vector<Index> face(stored.begin(), stored.end());
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    for (std::size_t i = 1; i + 1 < face.size(); ++i) add(face[0], face[i], face[i + 1]);
  });
  return triangles;
}

}  // namespace volccd
