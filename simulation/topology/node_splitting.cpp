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

/// Failure limits of the weakest part at a vertex.
struct Strength {
  double stress = kNever, strain = kNever;
};

Strength strength_at(const Topology& topology, std::span<const Part> parts, Index v) {
  Strength strength;
  for (Index o : topology.features().vertex_elements(v)) {
    const auto object = static_cast<std::size_t>(topology.mesh().object(o));
    assert(object < parts.size());
    if (parts[object].rigid) return {};
    strength.stress = std::min(strength.stress, parts[object].material.failure_stress);
    strength.strain = std::min(strength.strain, parts[object].material.failure_strain);
  }
  return strength;
}

std::vector<Failure> failures(const Topology& topology, std::span<const Part> parts,
                              std::span<const VertexStress> stress) {
  std::vector<Failure> failed;
  for (Index v = 0; v < topology.mesh().vertex_count(); ++v) {
    if (!(stress[v].volume > 0) || topology.features().vertex_elements(v).size() < 2) continue;
    const Eigen::Matrix3d mean = stress[v].stress / stress[v].volume;
    const double strain = stress[v].plastic_strain / stress[v].volume;
    if (!mean.allFinite() || !std::isfinite(strain))
      throw Error(fmt::format("the stress at vertex {} is not finite: the simulation has become unstable",
                              topology.mesh().vertex_id(v)));
    const Strength strength = strength_at(topology, parts, v);
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

TopologyProposal propose_splitting(const Topology& topology, std::span<const Part> parts,
                                   std::span<const Vec3> positions, std::span<const VertexStress> stress) {
  const Mesh& mesh = topology.mesh();
  assert(positions.size() >= mesh.vertex_count() && stress.size() >= mesh.vertex_count());
  TopologyProposal proposal;
  const auto fails = [](const Part& part) {
    return part.material.failure_stress != kNever || part.material.failure_strain != kNever;
  };
  if (std::none_of(parts.begin(), parts.end(), fails)) return proposal;

  std::vector<bool> barred(mesh.vertex_count(), false);
  std::vector<Index> positive;
  for (const Failure& failure : failures(topology, parts, stress)) {
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
