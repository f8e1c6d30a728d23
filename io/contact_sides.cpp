#include <volccd/io/contact_sides.hpp>

#include <algorithm>

namespace volccd {

namespace {

ContactSide side_of(std::span<const Index> elements, const Mesh& mesh) {
  ContactSide side;
  for (const Index o : elements)
    if (side.element < 0 || mesh.element_id(o) < side.element) side = {mesh.object(o), mesh.element_id(o)};
  return side;
}

std::span<const Index> edge_elements(const Features& features, Index v0, Index v1) {
  const Index edge = features.find_edge(v0, v1);
  return edge == kNone ? std::span<const Index>() : features.edge_elements(edge);
}

std::span<const Index> triangle_elements(const Features& features, Index v0, Index v1, Index v2) {
  const Index triangle = features.find_triangle(v0, v1, v2);
  return triangle == kNone ? std::span<const Index>() : features.triangle_elements(triangle);
}

}  // namespace

std::array<ContactSide, 2> contact_sides(const Contact& contact, const Topology& topology) {
  const Features& features = topology.features();
  const Mesh& mesh = topology.mesh();
  const auto& v = contact.vertices;
  if (contact.kind == FeatureKind::vf)
    return {side_of(features.vertex_elements(v[0]), mesh),
            side_of(triangle_elements(features, v[1], v[2], v[3]), mesh)};
  return {side_of(edge_elements(features, v[0], v[1]), mesh), side_of(edge_elements(features, v[2], v[3]), mesh)};
}

void add_part_pairs(int step, std::span<const Contact> contacts, const Topology& topology, PartPairs& pairs) {
  for (const Contact& contact : contacts) {
    const std::array<ContactSide, 2> sides = contact_sides(contact, topology);
    PartPairCount& count = pairs[std::minmax(sides[0].part, sides[1].part)];
    if (count.vf + count.ee == 0) count.first_step = step;
    ++(contact.kind == FeatureKind::vf ? count.vf : count.ee);
    if (count.first_step == step) count.first_toi = std::min(count.first_toi, contact.toi);
  }
}

}  // namespace volccd
