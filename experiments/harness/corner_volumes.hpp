// Corners of elements, and whether an element inverts.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <volccd/mesh/element_type.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

/// The tetrahedra {vertex, its three neighbours} at the corners of an element, as local vertex numbers, with positive
/// volume if the element has positive volume in VTK's node order: 1 of a tetrahedron, 4 of a pyramid (those of its
/// base), 6 of a wedge, 8 of a hexahedron, none of other types.
std::span<const std::array<std::uint8_t, 4>> corner_tetrahedra(ElementType type);

/// Six times the volume of the tetrahedron at a corner.
double corner_volume(const std::array<std::uint8_t, 4>& corner, std::span<const Index> vertices,
                     std::span<const Vec3> positions);

enum class Inversion {
  none,      ///< the volume at each corner is positive throughout the motion
  at_start,  ///< the volume at some corner is negative or zero at t = 0
  during     ///< all are positive at t = 0, and some are negative or zero later
};

/// The inversion test (flip test) over a whole motion: each volume is a cubic in t, and its least value in [0, 1] is
/// computed from its critical points, in floating point and without a bound on the error. An element that inverts and
/// turns back within the motion is found. `none` for types without corners. Pre: the motion has two control points.
Inversion inversion(ElementType type, std::span<const Index> vertices, const Motion& motion);

}  // namespace volccd
