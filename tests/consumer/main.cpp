// Two tetrahedra, of which the second falls onto the first: contacts of one step. README.md lists this file.
#include <cstdio>
#include <vector>

#include <volccd/pipelines/detector.hpp>

int main() {
  using namespace volccd;
  Mesh mesh;
  mesh.add_vertices(8);
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .object = 0, .id = 0});
  mesh.add_element({.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 7}, .object = 1, .id = 1});
  Detector detector(mesh, {.threads = 0});  // as many threads as the machine has

  const std::vector<Vec3> x0 = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                {-1, -1, 2}, {2, -1, 2}, {-1, 2, 2}, {0, 0, 3}};
  std::vector<Vec3> x1 = x0;
  for (std::size_t v = 4; v < 8; ++v) x1[v].z() -= 2;
  for (const Contact& contact : detector.step(x0, x1).contacts)
    std::printf("%s %u %u %u %u at t = %g\n", contact.kind == FeatureKind::vf ? "VF" : "EE", contact.vertices[0],
                contact.vertices[1], contact.vertices[2], contact.vertices[3], contact.toi);
  // The tip of the first meets the base of the second. Never late; early by less than a billionth of the step.
  const double toi = detector.result().statistics.earliest_toi;
  return toi <= 0.5 && toi > 0.5 - 1e-9 ? 0 : 1;
}
