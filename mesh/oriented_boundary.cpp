#include <volccd/mesh/oriented_boundary.hpp>

#include <algorithm>
#include <span>

#include <volccd/mesh/detail/element_tables.hpp>

namespace volccd {

std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o) {
  std::vector<std::array<Index, 3>> triangles;
  const auto add_face = [&](std::vector<Index> face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    for (std::size_t i = 1; i + 1 < face.size(); ++i) triangles.push_back({face[0], face[i], face[i + 1]});
  };
  const std::span<const Index> v = mesh.vertices(o), stream = mesh.polytope_faces(o);
  if (mesh.type(o) == ElementType::polytope) {
    for (std::size_t i = 0; i < stream.size(); i += stream[i] + std::size_t{1})
      add_face({stream.begin() + static_cast<std::ptrdiff_t>(i + 1),
                stream.begin() + static_cast<std::ptrdiff_t>(i + 1 + stream[i])});
    return triangles;
  }
  const detail::ElementTable& table = detail::element_table(mesh.type(o));
  for (std::size_t i = 0; i < table.triangles; ++i)
    triangles.push_back({v[table.triangle[i][0]], v[table.triangle[i][1]], v[table.triangle[i][2]]});
  for (std::size_t i = 0; i < table.quads; ++i)
    add_face({v[table.quad[i][0]], v[table.quad[i][1]], v[table.quad[i][2]], v[table.quad[i][3]]});
  return triangles;
}

}  // namespace volccd
