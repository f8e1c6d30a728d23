// Cuts: tetrahedra that a blade passes are subdivided along its plane, and the two sides part.
//
// An edge is divided when the point at which it crosses the plane lies in what the blade has covered; tetrahedra are
// subdivided by their divided edges, neighbours alike, so that the mesh conforms also at the front. A vertex near the
// plane (a crossing edge meets it within `snap` of the edge's length) is taken as on it, where it is: the cut bends
// to the vertex, no vertex moves, and no sliver arises. Faces between the sides, all of whose vertices the blade has
// covered, come apart: each vertex is copied for the elements that hang together no more; at the front they still do.
//
// Pieces fill their tetrahedron: volume and mass are kept to rounding, linear velocities and so momentum as well.
#pragma once

#include <span>

#include <volccd/simulation/topology_proposal.hpp>

namespace volccd::simulation {

/// Between 0 and its length: how far the edge of the blade has come at `time`.
double covered_depth(const Cut& cut, double time);

/// What is to be cut now that the blade has covered `depth`; empty if nothing is. Stateless: the mesh shows how far
/// it has been cut. Pieces have the object of their parent; one of them has its element id, the others get the next
/// ids.
///
/// `positions` (a vertex slot): those in which the plane of the cut is meant. Positions at rest keep the cut in its
/// plane however the body deforms meanwhile, and are what a simulation passes; those of the moment would cut anew
/// what moves across the plane behind the blade.
///
/// Throws ConfigError unless 0 <= snap < 0.5. Throws InputError for an element of cut.object that is not a
/// tetrahedron, and for a divided edge that an element of another object uses. Deterministic. O(elements): to be
/// called as often as the front is to advance, not at every time step.
TopologyProposal propose_cut(const Topology& topology, std::span<const Vec3> positions, const Cut& cut, double depth,
                             double snap = 0.15);

}  // namespace volccd::simulation
