// Improves a tetrahedral mesh by moving vertices.
#pragma once

#include <array>
#include <vector>

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>

namespace volccd {

/// Makes a few rounds over all vertices, in order. A vertex moves towards the centroid of its neighbours (a vertex of
/// the surface: of its neighbours on the surface, and is projected back onto it) as far as this increases the smallest
/// altitude of the tetrahedra around it. So no tetrahedron inverts, and the smallest altitude around a vertex never
/// decreases. Deterministic; O(tetrahedra) for each round.
void relax_tetrahedra(const ImplicitSolid& solid, std::vector<Vec3>& positions,
                      const std::vector<std::array<Index, 4>>& tetrahedra);

}  // namespace volccd
