// Fragments: hexahedra that have come loose and were drawn out break in two.
//
// Node splitting parts elements from each other, never an element: what is left of a failed zone are single elements,
// as long as they were drawn. One that shares no vertex with another, and is more than one and a half times as long along
// one of its axes as along the two others, breaks in the middle of that axis. No neighbour is left with a face that does
// not fit.
// Mass and momentum stay as they are; what the four new vertices' velocities lose in energy is the edit's.
#pragma once

#include <span>

#include <volccd/experiments/simulation/topology_proposal.hpp>

namespace volccd::simulation {

/// All such elements of parts that have a failure strain, by slot. A piece has half the length, so that it does not
/// break again at once. New vertices lie between two old ones, two in each place. O(elements).
TopologyProposal propose_breaking(const Topology& topology, std::span<const Part> parts,
                                  std::span<const Vec3> positions);

}  // namespace volccd::simulation
