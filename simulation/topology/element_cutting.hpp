// Cuts: tetrahedra that a blade passes are subdivided along its plane, and the two sides are separated.
//
// An edge is divided if it crosses the plane at a point that the blade has passed. Tetrahedra are subdivided according
// to their divided edges, in the same way in neighbours, so that the mesh is conforming, also at the front of the cut.
// A vertex near the plane (a crossing edge meets the plane within `snap` times the edge's length of it) counts as on
// the plane: the cut bends to the vertex, no vertex moves, and no slivers arise. Faces between the two sides are
// separated if the blade has passed all their vertices: each vertex is copied for the elements that are no longer
// connected at it; at the front they remain connected.
//
// The pieces of a tetrahedron fill it, so that volume and mass are conserved to rounding, and linear velocity fields
// and momentum as well.
#pragma once

#include <span>

#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

/// The distance, between 0 and the cut's length, that the edge of the blade has covered at `time`.
double covered_depth(const Cut& cut, double time);

/// The edit that makes the cut up to `depth`; empty if there is nothing to cut. Stateless: the mesh itself shows how
/// far it has been cut. Pieces have the object of their parent; one of them keeps its element id, the others get new
/// ids.
///
/// `positions` (by vertex slot): the positions to which the plane of the cut refers. A simulation passes positions at
/// rest, so that the cut stays in its plane however the body deforms. With present positions, material that moves
/// across the plane behind the blade would be cut again.
///
/// Throws ConfigError unless 0 <= snap < 0.5. Throws InputError for an element of cut.object that is not a
/// tetrahedron, and for a divided edge that an element of another object uses. Deterministic. O(elements); it should be
/// called when the front is to advance, not at every time step.
TopologyProposal propose_cut(const Topology& topology, std::span<const Vec3> positions, const Cut& cut, double depth,
                             double snap = 0.15);

}  // namespace volccd::simulation
