// Cracks through an element: hexahedra of a failed zone break in two along a diagonal.
//
// Node splitting (node_splitting.hpp) parts elements from each other and leaves each as it is: a crack follows faces. A
// hexahedron that has been drawn far enough by itself breaks into two wedges, by that of its diagonal planes which lies
// most nearly across the greatest tension; the vertices on it may split afterwards, as others do. Only hexahedra of
// which the two faces that the plane crosses are free, and are triangulated along it already, may break: no face of a
// neighbour is divided, no vertex is new, and the surface stays as it is, so that nothing that touched before is
// crossed afterwards.
//
// Mass stays at each vertex, and with it momentum (see SolidForces); the energy of hourglass modes is the edit's.
#pragma once

#include <span>

#include <volccd/simulation/topology_proposal.hpp>

namespace volccd::simulation {

/// All such hexahedra of deformable parts, by slot: their plastic strain (a mean over their vertices) is beyond the
/// part's breaking strain, they are drawn more than they are pressed (the mean stress is tension), and nothing presses
/// against them. Those that are folded, or would break into pieces of very different volume, stay. One piece keeps the
/// id, the other has a new one.
///
/// `positions`, `stress`, `pressed` (whether a contact bears on it): a vertex slot of the topology; `parts`: by object
/// id. O(elements).
TopologyProposal propose_breaking(const Topology& topology, std::span<const Part> parts,
                                  std::span<const Vec3> positions, std::span<const VertexStress> stress,
                                  std::span<const char> pressed);

}  // namespace volccd::simulation
