// Cracks through elements: hexahedra in a failed zone break in two along a diagonal.
//
// Node splitting (node_splitting.hpp) separates elements and does not change their shapes, so that a crack follows
// faces. A hexahedron that is itself stretched far enough breaks into two wedges, along the one of its diagonal planes
// that is most nearly normal to the greatest tension; its vertices may split afterwards like any others. A hexahedron
// may break only if the two faces that the plane crosses are on the surface, and are already triangulated along the
// plane. So no face of a neighbour is divided, no vertex is added, and the surface is unchanged, so that no new
// intersections arise.
//
// The mass and the momentum of each vertex do not change (see solid_forces.hpp); the energy of hourglass modes is
// counted as lost in the edit.
#pragma once

#include <span>

#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

/// Breaks, in order of slots, all hexahedra of deformable bodies that meet these conditions: their plastic strain (the
/// mean over their vertices) exceeds the body's breaking strain, the mean stress is tension, and no contact presses on
/// them. Hexahedra that are folded, or would break into pieces of very different volume, do not break. One piece keeps
/// the id, the other gets a new one.
///
/// `positions`, `stress`, `pressed` (whether a contact presses on the vertex): by vertex slot; `bodies`: by object id.
/// O(elements).
TopologyProposal propose_breaking(const Topology& topology, std::span<const Body> bodies,
                                  std::span<const Vec3> positions, std::span<const VertexStress> stress,
                                  std::span<const char> pressed);

}  // namespace volccd::simulation
