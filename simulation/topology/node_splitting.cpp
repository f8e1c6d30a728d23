#include <volccd/simulation/topology/node_splitting.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include <volccd/simulation/elements/principal_stress.hpp>

namespace volccd::simulation {

namespace {

struct Failure {
  double excess;  ///< ratio to the limit of the material, above 1
  Index vertex;
  Vec3 direction;
};

/// Failure limits of the weakest body at a vertex.
struct Strength {
  double stress = kNever, strain = kNever;
};

Strength strength_at(const Topology& topology, std::span<const Body> bodies, Index v) {
  Strength strength;
  for (Index o : topology.features().vertex_elements(v)) {
    const auto object = static_cast<std::size_t>(topology.mesh().object(o));
    assert(object < bodies.size());
    if (bodies[object].rigid) return {};
    strength.stress = std::min(strength.stress, bodies[object].material.failure_stress);
    strength.strain = std::min(strength.strain, bodies[object].material.failure_strain);
  }
  return strength;
}

std::vector<Failure> failures(const Topology& topology, std::span<const Body> bodies,
                              std::span<const VertexStress> stress) {
  std::vector<Failure> failed;
  for (Index v = 0; v < topology.mesh().vertex_count(); ++v) {
    if (!(stress[v].volume > 0) || topology.features().vertex_elements(v).size() < 2) continue;
    const Eigen::Matrix3d mean = stress[v].stress / stress[v].volume;
    const double strain = stress[v].plastic_strain / stress[v].volume;
    if (!mean.allFinite() || !std::isfinite(strain))
      throw Error(fmt::format("the stress at vertex {} is not finite: the simulation has become unstable",
                              topology.mesh().vertex_id(v)));
    const Strength strength = strength_at(topology, bodies, v);
    // The norm bounds every principal stress, so that principal directions are needed for few vertices only.
    if (!(mean.norm() > strength.stress) && !(strain > strength.strain)) continue;
    const PrincipalStress principal = greatest_principal(mean);
    if (!(principal.value > 0)) continue;  // compression from all sides
    const double excess = std::max(principal.value / strength.stress, strain / strength.strain);
    if (excess > 1) failed.push_back({excess, v, principal.direction});
  }
  std::sort(failed.begin(), failed.end(), [](const Failure& a, const Failure& b) {
    return std::tuple(-a.excess, a.vertex) < std::tuple(-b.excess, b.vertex);
  });
  return failed;
}

Vec3 centroid(std::span<const Index> vertices, std::span<const Vec3> positions) {
  Vec3 sum = Vec3::Zero();
  for (Index v : vertices) sum += positions[v];
  return sum / static_cast<double>(vertices.size());
}

}  // namespace

TopologyProposal propose_splitting(const Topology& topology, std::span<const Body> bodies,
                                   std::span<const Vec3> positions, std::span<const VertexStress> stress) {
  const Mesh& mesh = topology.mesh();
  assert(positions.size() >= mesh.vertex_count() && stress.size() >= mesh.vertex_count());
  TopologyProposal proposal;
  const auto fails = [](const Body& body) {
    return body.material.failure_stress != kNever || body.material.failure_strain != kNever;
  };
  if (std::none_of(bodies.begin(), bodies.end(), fails)) return proposal;

  std::vector<bool> barred(mesh.vertex_count(), false);
  std::vector<Index> positive;
  for (const Failure& failure : failures(topology, bodies, stress)) {
    if (barred[failure.vertex]) continue;
    const std::span<const Index> elements = topology.features().vertex_elements(failure.vertex);
    const Vec3& x = positions[failure.vertex];
    positive.clear();
    for (Index o : elements)
      if ((centroid(mesh.vertices(o), positions) - x).dot(failure.direction) > 0) positive.push_back(o);
    if (positive.empty() || positive.size() == elements.size()) continue;

    const Index copy = add_copy(proposal, mesh, failure.vertex);
    for (Index o : positive) {
      ElementSpec element = element_spec(mesh, o);
      replace_vertex(element, failure.vertex, copy);
      replace_element(proposal, o, std::move(element));
    }
    for (Index o : elements)
      for (Index v : mesh.vertices(o)) barred[v] = true;
  }
  return proposal;
}

}  // namespace volccd::simulation
