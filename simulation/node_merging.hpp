// Welding: vertices in touch merge where the contact force is great enough (Algorithm 1, lines 27 to 33).
#pragma once

#include <span>

#include <volccd/query/contact.hpp>
#include <volccd/simulation/topology_proposal.hpp>

namespace volccd::simulation {

/// A contact and the force that it exerts.
struct LoadedContact {
  Contact contact;   ///< vertices are slots of the topology
  double force = 0;  ///< magnitude, N
};

/// A vertex of one feature of a contact and a vertex of the other merge when they are nearer than the merging
/// distance and the force exceeds the merging force; of two parts, the smaller distance and the greater force count.
/// The vertex of lower slot stays, at their centre of mass, with their common momentum; the elements of the other
/// take it over, with the shapes at rest that they had (TopologyProposal::shapes_of_parents); the other vertex is
/// used by no element then. Kinetic energy is lost as in a plastic impact.
///
/// The nearest pair first (then by slots). A pair is refused when
///   - an element has both vertices, or one of the parts is rigid;
///   - a face would get a third element, or two on the same side of it;
///   - an element at either would be inverted, or lose nine tenths of its volume (a shell: its area; a hexahedron: the
///     volume at any of its corners);
///   - an element at either is changed already in this call.
///
/// `positions`, `velocities`, `mass`: a vertex slot. Vertices of elements other than tetrahedra, hexahedra and
/// triangles never merge. O(contacts log contacts + elements at those that merge).
TopologyProposal propose_merging(const Topology& topology, std::span<const Part> parts,
                                 std::span<const LoadedContact> contacts, std::span<const Vec3> positions,
                                 std::span<const Vec3> velocities, std::span<const double> mass);

}  // namespace volccd::simulation
