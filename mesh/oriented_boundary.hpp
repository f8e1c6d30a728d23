// The triangulated boundary of an element with its orientation.
#pragma once

#include <array>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// The triangles of the boundary of live element o (visit_boundary in mesh/features.hpp), each as three vertex slots in
/// the cyclic order of its face. Those of a volume point outward where the element has a positive volume in VTK's node
/// order; of a polytope, where its faces are so stored. A triangle that two faces of a degenerate polytope have comes
/// twice.
std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o);

}  // namespace volccd
