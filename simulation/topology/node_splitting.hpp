// Cracks: vertices split where the material fails (Algorithm 1, lines 34 to 38).
//
// A vertex fails if the greatest principal stress at it exceeds the failure stress of any body at it, or if that stress
// is tension and the equivalent plastic strain exceeds the failure strain. Tension is required because material under
// compression from all sides flows and does not fracture (Cockcroft and Latham 1968); also, a fragment without stress
// is not split further. The plane through the vertex normal to the principal direction divides the elements at it by
// their centroids. Those on the positive side get a copy of the vertex, with the same position and velocity (O'Brien
// and Hodgins 1999, without their remeshing: cracks follow the faces of the elements). Elements that are connected only
// at vertices or edges afterwards are left to later steps.
//
// Mass, momentum and energy do not change, because elements change their vertices but not their shapes.
#pragma once

#include <span>

#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

/// Splits vertices that fail, in descending order of the ratio of the stress or strain to its limit (then by slot).
/// After a vertex has split, the other vertices of its elements do not split in this call, so that a crack grows step
/// by step and the stress at its tip is that of the new shape. A vertex does not split if all its elements are on one
/// side, or if one of them belongs to a rigid body.
///
/// `positions`, `stress`: by vertex slot; `bodies`: by object id. There should be some time steps between two calls,
/// because the stress at a new surface decreases only at the speed of sound. Throws Error if a stress is not finite.
/// All element types. O(vertices + elements at those that split).
TopologyProposal propose_splitting(const Topology& topology, std::span<const Body> bodies,
                                   std::span<const Vec3> positions, std::span<const VertexStress> stress);

}  // namespace volccd::simulation
