#include <volccd/simulation/topology/element_breaking.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include <volccd/simulation/elements/principal_stress.hpp>

namespace volccd::simulation {

namespace {

/// Least cosine of the angle between tension and the plane's normal; least share of the volume of each piece.
constexpr double kAcross = 0.7, kMinShare = 0.3;

/// Opposite faces of a hexahedron in VTK's order; corner i of one is over corner i of the other. The first is
/// counter-clockwise as seen from the second.
using Faces = std::array<std::array<std::size_t, 4>, 2>;
constexpr Faces kFaces[3] = {
    {{{0, 1, 2, 3}, {4, 5, 6, 7}}}, {{{0, 4, 5, 1}, {3, 7, 6, 2}}}, {{{0, 3, 7, 4}, {1, 2, 6, 5}}}};

/// Corners of two wedges, in VTK's order. The second of each triangle is off the diagonal.
struct Pieces {
  std::array<Index, 6> first, second;
};

/// The plane through corner `i` of the first face, the one after the next, and those over them.
Pieces pieces(std::span<const Index> vertices, const Faces& faces, std::size_t i) {
  const auto at = [&](std::size_t face, std::size_t corner) { return vertices[faces[face][(i + corner) % 4]]; };
  return {{at(0, 2), at(0, 1), at(0, 0), at(1, 2), at(1, 1), at(1, 0)},
          {at(0, 0), at(0, 3), at(0, 2), at(1, 0), at(1, 3), at(1, 2)}};
}

/// Whether no other element has this face, and it is triangulated along the diagonal from corner `i`.
bool is_free_along(const Features& features, std::span<const Index> vertices, const std::array<std::size_t, 4>& face,
                   std::size_t i) {
  const auto at = [&](std::size_t corner) { return vertices[face[(i + corner) % 4]]; };
  for (const std::size_t off : {1, 3}) {
    const Index f = features.find_triangle(at(0), at(2), at(off));
    if (f == kNone || features.triangle_elements(f).size() != 1) return false;
  }
  return true;
}

/// Three tetrahedra.
double volume(const std::array<Index, 6>& w, std::span<const Vec3> x) {
  double six = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& apex = x[w[i]];
    six -= (x[w[i + 1]] - apex).cross(x[w[i + 2]] - apex).dot(x[w[i + 3]] - apex);
  }
  return six / 6;
}

/// The plane along which the element breaks, or nothing.
std::optional<Pieces> find_plane(const Topology& topology, Index o, const Vec3& tension, std::span<const Vec3> x) {
  const std::span<const Index> vertices = topology.mesh().vertices(o);
  std::optional<Pieces> best;
  double max = kAcross;
  for (const Faces& faces : kFaces)
    for (std::size_t i = 0; i < 2; ++i) {
      if (!is_free_along(topology.features(), vertices, faces[0], i) ||
          !is_free_along(topology.features(), vertices, faces[1], i))
        continue;
      const Pieces p = pieces(vertices, faces, i);
      const std::array<Index, 6>& w = p.first;  // corners 0 and 2, and 3 and 5 above them, are in the plane
      const Vec3 normal = (x[w[0]] + x[w[3]] - x[w[2]] - x[w[5]]).cross(x[w[3]] + x[w[5]] - x[w[0]] - x[w[2]]);
      const double across = std::abs(normal.dot(tension)) / normal.norm();
      const double first = volume(p.first, x), second = volume(p.second, x);
      if (!(across > max) || !(std::min(first, second) > kMinShare * (first + second))) continue;
      max = across;
      best = p;
    }
  return best;
}

/// Mean over the element's vertices of the stresses there.
VertexStress stress_in(std::span<const Index> vertices, std::span<const VertexStress> stress) {
  VertexStress sum;
  for (const Index v : vertices) {
    sum.stress += stress[v].stress;
    sum.plastic_strain += stress[v].plastic_strain;
    sum.volume += stress[v].volume;
  }
  return sum;
}

}  // namespace

TopologyProposal propose_breaking(const Topology& topology, std::span<const Body> bodies,
                                  std::span<const Vec3> positions, std::span<const VertexStress> stress,
                                  std::span<const char> pressed) {
  const Mesh& mesh = topology.mesh();
  assert(positions.size() >= mesh.vertex_count() && stress.size() >= mesh.vertex_count() &&
         pressed.size() >= mesh.vertex_count());
  TopologyProposal proposal;
  proposal.shapes_of_parents = false;
  if (std::ranges::none_of(bodies, [](const Body& body) { return body.material.breaking_strain < kNever; }))
    return proposal;
  std::int64_t last_id = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) last_id = std::max(last_id, mesh.element_id(o));
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o) || mesh.type(o) != ElementType::hexahedron) continue;
    const Body& body = bodies[static_cast<std::size_t>(mesh.object(o))];
    if (body.rigid || body.material.breaking_strain == kNever) continue;
    const VertexStress mean = stress_in(mesh.vertices(o), stress);
    if (!(mean.plastic_strain > body.material.breaking_strain * mean.volume)) continue;
    if (!(mean.stress.trace() > 0) || std::ranges::any_of(mesh.vertices(o), [&](Index v) { return pressed[v] != 0; }))
      continue;
    const Vec3 tension = greatest_principal(mean.stress / mean.volume).direction;
    const std::optional<Pieces> found = find_plane(topology, o, tension, positions);
    if (!found) continue;
    ElementSpec first = element_spec(mesh, o);
    first.type = ElementType::wedge;
    ElementSpec second = first;
    second.id = ++last_id;
    first.vertices.assign(found->first.begin(), found->first.end());
    second.vertices.assign(found->second.begin(), found->second.end());
    replace_element(proposal, o, std::move(first));
    proposal.parents.push_back(o);
    proposal.edit.added.push_back(std::move(second));
  }
  return proposal;
}

}  // namespace volccd::simulation
