#include <volccd/simulation/topology/topology_proposal.hpp>

#include <cassert>

namespace volccd::simulation {

namespace {

void archive_spec(Archive& archive, ElementSpec& spec) {
  archive(spec.type);
  archive(spec.vertices);
  archive(spec.faces);
  archive(spec.object);
  archive(spec.id);
}

}  // namespace

ElementSpec element_spec(const Mesh& mesh, Index o) {
  ElementSpec spec;
  spec.type = mesh.type(o);
  spec.vertices.assign(mesh.vertices(o).begin(), mesh.vertices(o).end());
  spec.faces.assign(mesh.polytope_faces(o).begin(), mesh.polytope_faces(o).end());
  spec.object = mesh.object(o);
  spec.id = mesh.element_id(o);
  return spec;
}

void replace_vertex(ElementSpec& element, Index from, Index to) {
  element.renumber([&](Index v) { return v == from ? to : v; });
}

Index add_copy(TopologyProposal& proposal, const Mesh& mesh, Index vertex) {
  const Index present = mesh.vertex_count();
  const auto slot = static_cast<Index>(present + proposal.new_vertices.size());
  assert(vertex < slot);
  proposal.edit.new_vertex_ids.push_back(mesh.vertex_id(present - 1) + 1 + (slot - present));
  proposal.new_vertices.push_back(vertex < present ? VertexOrigin{{vertex, vertex}, {1.0, 0.0}}
                                                   : VertexOrigin(proposal.new_vertices[vertex - present]));
  return slot;
}

void replace_element(TopologyProposal& proposal, Index o, ElementSpec element) {
  proposal.edit.removed.push_back(o);
  proposal.parents.push_back(o);
  proposal.edit.added.push_back(std::move(element));
}

void inherit(const TopologyProposal& proposal, std::vector<Vec3>& values) {
  values.reserve(values.size() + proposal.new_vertices.size());
  for (const VertexOrigin& origin : proposal.new_vertices) {
    const Vec3& first = values[origin.parents[0]];
    // A copy is one bit for bit, also of a value with a -0 in it.
    values.push_back(origin.parents[0] == origin.parents[1]
                         ? Vec3(first)
                         : Vec3(origin.weights[0] * first + origin.weights[1] * values[origin.parents[1]]));
  }
}

ElementHeritage heritage_of(const TopologyProposal& proposal, const Mesh& after) {
  ElementHeritage heritage;
  heritage.removed = proposal.edit.removed;
  heritage.parents = proposal.parents;
  for (const ElementSpec& element : proposal.edit.added) {
    heritage.added.push_back(after.find_element(element.id));
    assert(heritage.added.back() != kNone);
  }
  return heritage;
}

void archive_proposal(Archive& archive, TopologyProposal& proposal) {
  archive(proposal.edit.removed);
  archive(proposal.edit.new_vertex_ids);
  std::uint64_t added = proposal.edit.added.size();
  archive(added);
  proposal.edit.added.resize(static_cast<std::size_t>(added));
  for (ElementSpec& spec : proposal.edit.added) archive_spec(archive, spec);
  archive(proposal.new_vertices);
  archive(proposal.parents);
  archive(proposal.moved);
  archive(proposal.shapes_of_parents);
}

}  // namespace volccd::simulation
