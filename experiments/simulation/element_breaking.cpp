#include <volccd/experiments/simulation/element_breaking.hpp>

#include <algorithm>
#include <array>
#include <cassert>

namespace volccd::simulation {

namespace {

/// Of the length along an axis to the mean of the two others.
constexpr double kDrawnOut = 1.5;

/// Edges along each axis of a hexahedron in VTK's order, from the one side to the other.
constexpr std::size_t kAlong[3][4][2] = {
    {{0, 1}, {3, 2}, {4, 5}, {7, 6}}, {{0, 3}, {1, 2}, {4, 7}, {5, 6}}, {{0, 4}, {1, 5}, {2, 6}, {3, 7}}};

bool is_loose(const Topology& topology, Index o) {
  return std::ranges::all_of(topology.mesh().vertices(o),
                             [&](Index v) { return topology.features().vertex_elements(v).size() == 1; });
}

/// 3: none.
std::size_t drawn_axis(std::span<const Index> vertices, std::span<const Vec3> positions) {
  std::array<double, 3> length{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& edge : kAlong[axis])
      length[axis] += (positions[vertices[edge[1]]] - positions[vertices[edge[0]]]).norm();
  const auto longest = static_cast<std::size_t>(std::ranges::max_element(length) - length.begin());
  const double others = (length[0] + length[1] + length[2] - length[longest]) / 2;
  return length[longest] > kDrawnOut * others ? longest : 3;
}

Index add_middle(TopologyProposal& proposal, const Mesh& mesh, Index a, Index b) {
  const Index middle = add_copy(proposal, mesh, a);
  proposal.new_vertices.back() = {{a, b}, {0.5, 0.5}};
  return middle;
}

}  // namespace

TopologyProposal propose_breaking(const Topology& topology, std::span<const Part> parts,
                                  std::span<const Vec3> positions) {
  const Mesh& mesh = topology.mesh();
  assert(positions.size() >= mesh.vertex_count());
  TopologyProposal proposal;
  proposal.shapes_of_parents = false;
  std::int64_t last_id = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.alive(o)) last_id = std::max(last_id, mesh.element_id(o));
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.alive(o) || mesh.type(o) != ElementType::hexahedron) continue;
    const Part& part = parts[static_cast<std::size_t>(mesh.object(o))];
    if (part.rigid || part.material.failure_strain == kNever || !is_loose(topology, o)) continue;
    const std::span<const Index> vertices = mesh.vertices(o);
    const std::size_t axis = drawn_axis(vertices, positions);
    if (axis == 3) continue;
    ElementSpec first = element_spec(mesh, o), second = first;
    second.id = ++last_id;
    for (const auto& [from, to] : kAlong[axis]) {
      first.vertices[to] = add_middle(proposal, mesh, vertices[from], vertices[to]);
      second.vertices[from] = add_middle(proposal, mesh, vertices[from], vertices[to]);
    }
    replace_element(proposal, o, std::move(first));
    proposal.parents.push_back(o);
    proposal.edit.added.push_back(std::move(second));
  }
  return proposal;
}

}  // namespace volccd::simulation
