// Vertices of a tetrahedral mesh moved to where the tetrahedra are less flat.
#pragma once

#include <array>
#include <vector>

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>

namespace volccd {

/// A few rounds over all vertices, in order. A vertex moves towards the middle of its neighbours (one of the surface:
/// of its neighbours there, and back onto the solid's surface) if, and as far as, that raises the smallest altitude of
/// the tetrahedra around it: no smallest altitude ever falls, nothing turns over. Deterministic; O(tetrahedra) a round.
void relax_tetrahedra(const ImplicitSolid& solid, std::vector<Vec3>& positions,
                      const std::vector<std::array<Index, 4>>& tetrahedra);

}  // namespace volccd
