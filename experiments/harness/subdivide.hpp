// Finer meshes of the same motion, for the tables of scaling.
#pragma once

#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

struct RefinedStep {
  Mesh mesh;
  Motion motion;
};

enum class Division {
  everywhere,  ///< triangles and quads into 4, tetrahedra, wedges and hexahedra into 8
  in_plane     ///< thickened shells: wedges and hexahedra into 4, with unchanged thickness
};

/// Divides each element at the midpoints of its edges, `times` times. The control points of a new vertex are the means
/// of those of the corners between which it lies, so that neighbours agree and the motion is the same. Vertices that no
/// element uses are left out. Object ids are kept; element ids are renumbered. Throws ConfigError for pyramids and
/// polytopes, and for tetrahedra in the plane. O(elements of the result) expected.
RefinedStep refine(const Topology& topology, const Motion& motion, int times, Division division = Division::everywhere);

}  // namespace volccd
