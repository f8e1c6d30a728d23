// What a topology edit of a simulation is before it is applied: the edit, and what its new vertices and elements
// inherit.
//
// How a loop applies one, with `x`, `v`, `reference` its values a vertex:
//   inherit(proposal, x); inherit(proposal, v); inherit(proposal, reference);
//   for (const MovedVertex& moved : proposal.moved) { x[moved.vertex] = ...; v[moved.vertex] = ...; }
//   topology.apply(proposal.edit);
//   forces.update(topology.mesh(), reference, heritage_of(proposal, topology.mesh()));
//   masses anew, from nothing; a vertex that no element uses any more has none.
#pragma once

#include <array>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/simulation/element_forces.hpp>

namespace volccd::simulation {

/// Any quantity at a new vertex is weights[0] * at parents[0] + weights[1] * at parents[1], its parents being
/// vertices from before the edit. A vertex that is copied has its original twice, with weights 1 and 0.
struct VertexOrigin {
  std::array<Index, 2> parents;
  std::array<double, 2> weights;
};

/// A vertex that was there before and that the edit puts elsewhere.
struct MovedVertex {
  Index vertex;
  Vec3 position, velocity;
};

/// Topology::apply accepts `edit` as long as the topology is the one it was made for.
struct TopologyProposal {
  TopologyEdit edit;
  std::vector<VertexOrigin> new_vertices;  ///< one for each of edit.new_vertex_ids; their slots follow the present ones
  std::vector<Index> parents;              ///< one for each of edit.added: slot of its parent, among edit.removed
  std::vector<MovedVertex> moved;
  /// Every added element has the vertices of its parent, one by one, some of them under another slot, and therefore its
  /// shape at rest, even where the reference positions of those vertices say otherwise (merging). Else (cutting) added
  /// elements are pieces of their parents and have the shapes that the reference positions give.
  bool shapes_of_parents = true;

  bool empty() const { return edit.empty(); }
};

/// The element in slot o as Mesh::add_element takes it.
ElementSpec element_spec(const Mesh& mesh, Index o);

/// Replaces vertex `from` of an element by `to`, in its faces also.
void replace_vertex(ElementSpec& element, Index from, Index to);

/// Appends a copy of `vertex` to the new vertices and returns the slot that it will have.
Index add_copy(TopologyProposal& proposal, const Mesh& mesh, Index vertex);

/// Has the element in slot o replaced by `element`, which takes its state over.
void replace_element(TopologyProposal& proposal, Index o, ElementSpec element);

/// Appends the values of the new vertices to those of the present ones.
void inherit(const TopologyProposal& proposal, std::vector<Vec3>& values);

/// The same edit in slots; `after`: the mesh to which it has been applied.
ElementHeritage heritage_of(const TopologyProposal& proposal, const Mesh& after);

}  // namespace volccd::simulation
