// A topology edit of a simulation that has not been applied yet: the edit, and what its new vertices and elements
// inherit.
//
// A time loop applies it as follows, where `x`, `v` and `reference` are its values by vertex:
//   inherit(proposal, x); inherit(proposal, v); inherit(proposal, reference);
//   for (const MovedVertex& moved : proposal.moved) { x[moved.vertex] = ...; v[moved.vertex] = ...; }
//   topology.apply(proposal.edit);
//   forces.update(topology.mesh(), reference, heritage_of(proposal, topology.mesh()));
//   compute all masses again; a vertex that no element uses has mass 0.
#pragma once

#include <array>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/elements/element_forces.hpp>

namespace volccd::simulation {

/// A quantity q at a new vertex is weights[0] * q(parents[0]) + weights[1] * q(parents[1]), where the parents are
/// vertices from before the edit. Both parents of a copy are the original vertex, with weights 1 and 0.
struct VertexOrigin {
  std::array<Index, 2> parents;
  std::array<double, 2> weights;
};

/// A vertex from before the edit whose position and velocity the edit changes.
struct MovedVertex {
  Index vertex;
  Vec3 position, velocity;
};

/// Valid for the topology for which it was made: Topology::apply accepts `edit` until that topology changes.
struct TopologyProposal {
  TopologyEdit edit;
  std::vector<VertexOrigin> new_vertices;  ///< one for each of edit.new_vertex_ids; their slots follow the present ones
  std::vector<Index> parents;              ///< one for each of edit.added: slot of its parent, among edit.removed
  std::vector<MovedVertex> moved;
  /// True: every added element corresponds to its parent vertex by vertex, although some vertices have other slots, and
  /// keeps its shape at rest, even if the reference positions of its vertices differ (merging). False (cutting): added
  /// elements are pieces of their parents and have the shapes that the reference positions give.
  bool shapes_of_parents = true;

  bool empty() const { return edit.empty(); }
};

/// The element in slot o in the form that Mesh::add_element takes.
ElementSpec element_spec(const Mesh& mesh, Index o);

/// Replaces vertex `from` of an element by `to`, also in its faces.
void replace_vertex(ElementSpec& element, Index from, Index to);

/// Appends a copy of `vertex` to the new vertices and returns the slot that it will have.
Index add_copy(TopologyProposal& proposal, const Mesh& mesh, Index vertex);

/// Adds to the edit that `element` replaces the element in slot o and inherits its state.
void replace_element(TopologyProposal& proposal, Index o, ElementSpec element);

/// Appends the values of the new vertices to those of the present ones.
void inherit(const TopologyProposal& proposal, std::vector<Vec3>& values);

/// The removed and added elements of the edit as slots; `after`: the mesh to which it has been applied.
ElementHeritage heritage_of(const TopologyProposal& proposal, const Mesh& after);

/// Writes the proposal, or reads it into an empty one.
void archive_proposal(Archive& archive, TopologyProposal& proposal);

}  // namespace volccd::simulation
