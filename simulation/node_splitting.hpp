// Cracks: vertices split where the material fails (Algorithm 1, lines 34 to 38).
//
// A vertex fails when the greatest principal stress at it exceeds the failure stress of any part at it, or is tension
// and the equivalent plastic strain exceeds the failure strain: what is pressed together from all sides flows and does
// not part (Cockcroft and Latham 1968), and a part that has come loose is not parted further. The plane through it
// normal to the principal direction parts the elements at it by their centroids; those on the positive side get a copy
// of the vertex, in the same place and with the same velocity (O'Brien and Hodgins 1999, without their remeshing:
// cracks follow the faces of the elements). Elements that meet in single vertices or edges afterwards are left to the
// next steps.
//
// Mass, momentum and energy stay as they are: elements change vertices, not shapes.
#pragma once

#include <span>

#include <volccd/simulation/topology_proposal.hpp>

namespace volccd::simulation {

/// Splits vertices that fail, the worst first (ratio to what the material bears; then by slot). A vertex that splits
/// bars those of the elements at it for this call, so that cracks grow by steps and the stress at their tips is that
/// of the new shape. Vertices whose elements are all on one side, or of which one is of a rigid part, do not split.
///
/// `positions`, `stress`: a vertex slot of the topology; `parts`: by object id. Callers leave some time steps between
/// two calls: the stress at a new surface falls as fast as sound travels. Throws Error if a stress is not finite. All
/// element types. O(vertices + elements at those that split).
TopologyProposal propose_splitting(const Topology& topology, std::span<const Part> parts,
                                   std::span<const Vec3> positions, std::span<const VertexStress> stress);

}  // namespace volccd::simulation
