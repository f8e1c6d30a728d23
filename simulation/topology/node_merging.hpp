// Welding: touching vertices merge if the contact force is large enough (Algorithm 1, lines 27 to 33).
#pragma once

#include <span>

#include <volccd/query/contact.hpp>
#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

/// A contact and its force.
struct LoadedContact {
  Contact contact;   ///< vertices are slots of the topology
  double force = 0;  ///< magnitude, N
};

/// A vertex of one feature of a contact and a vertex of the other merge when they are nearer than the merging
/// distance and the force exceeds the merging force; for two bodies, the smaller distance and the greater force count.
/// The vertex of lower slot remains, at their centre of mass, with the sum of their momenta. The elements of the other
/// vertex use it instead and keep their shapes at rest (TopologyProposal::shapes_of_parents); no element uses the other
/// vertex then. Kinetic energy is lost as in a plastic impact.
///
/// Pairs merge in order of their distance (then by slots). A pair does not merge if
///   - an element has both vertices, or one of the bodies is rigid;
///   - a face would get a third element, or two on the same side of it;
/// - an element at either vertex would be inverted, or lose nine tenths of its volume (a shell: of its area; a
///   hexahedron: of the volume at any of its corners);
/// - an element at either vertex has already been changed in this call.
///
/// `positions`, `velocities`, `mass`: by vertex slot. Vertices of elements other than tetrahedra, hexahedra and
/// triangles never merge. O(contacts log contacts + elements at those that merge).
TopologyProposal propose_merging(const Topology& topology, std::span<const Body> bodies,
                                 std::span<const LoadedContact> contacts, std::span<const Vec3> positions,
                                 std::span<const Vec3> velocities, std::span<const double> mass);

}  // namespace volccd::simulation
