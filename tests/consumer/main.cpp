// Two tetrahedra, of which the second falls onto the first: contacts of one step. README.md lists this file.
#include <cstdio>
#include <vector>

#include <volccd/pipelines/pipeline.hpp>

int main() {
  using namespace volccd;

  Mesh mesh;
  mesh.add_vertices(8);
  mesh.add_element({ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0});  // vertices, faces of a polytope, object, id
  mesh.add_element({ElementType::tetrahedron, {4, 5, 6, 7}, {}, 1, 1});
  const Topology topology(std::move(mesh));

  const std::vector<Vec3> x0 = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                {-1, -1, 2}, {2, -1, 2}, {-1, 2, 2}, {0, 0, 3}};
  std::vector<Vec3> x1 = x0;
  for (std::size_t v = 4; v < 8; ++v) x1[v].z() -= 2;
  const Motion motion = Motion::linear(x0, x1);

  const Registry registry = Registry::standard();
  const Pipeline pipeline(registry, registry.pipeline("VolCCD+"));
  Workspace workspace = pipeline.make_workspace();
  const auto executor = make_executor(0);
  const ObjectFilter filter;
  StepResult result;
  pipeline.run({topology, motion, filter}, workspace, *executor, result);

  for (const Contact& contact : result.contacts)
    std::printf("%s %u %u %u %u at t = %g\n", contact.kind == FeatureKind::vf ? "VF" : "EE", contact.vertices[0],
                contact.vertices[1], contact.vertices[2], contact.vertices[3], contact.toi);
  // The tip of the first meets the base of the second. Never late; early by less than a billionth of the step.
  const double toi = result.statistics.earliest_toi;
  return toi <= 0.5 && toi > 0.5 - 1e-9 ? 0 : 1;
}
