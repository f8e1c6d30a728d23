// The oriented, triangulated boundary of an element.
#pragma once

#include <array>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// The boundary triangles of live element o (visit_boundary in mesh/features.hpp), each as three vertex slots in the
/// cyclic order of its face. For a volume element of positive volume in VTK's node order they are oriented outward; for
/// a polytope they have the orientation of its stored faces. If two faces of a degenerate polytope have the same
/// triangle, it is returned twice.
std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o);

}  // namespace volccd
