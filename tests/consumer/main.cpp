// Two tetrahedra through the installed headers and libraries.
#include <cstdio>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology.hpp>

int main() {
  volccd::Mesh mesh;
  mesh.add_vertices(8);
  mesh.add_element({volccd::ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0});
  mesh.add_element({volccd::ElementType::tetrahedron, {4, 5, 6, 7}, {}, 1, 1});
  const volccd::Topology topology(std::move(mesh));

  const auto executor = volccd::make_executor(2);
  std::printf("%u elements, %u edges, %u triangles, %u workers\n", topology.mesh().element_count(),
              topology.features().edge_count(), topology.features().triangle_count(), executor->workers());
  const bool right = topology.features().edge_count() == 12 && topology.features().triangle_count() == 8;
  return right ? 0 : 1;
}
