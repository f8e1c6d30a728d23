// Planes through a common vertex that separate simplices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// The other vertices of a simplex relative to one of its vertices, at all control points, as rows of lanes: the
/// coordinate k of vector i is x[k][i]. Vectors are repeated to fill the rows.
struct alignas(64) CornerVectors {
  static constexpr std::size_t kLanes = 16;
  double x[3][kLanes];

  /// Two or three control points; a triangle or a tetrahedron with the vertex `corner`.
  CornerVectors(const Motion& motion, std::span<const Index> vertices, Index corner);
};

/// Sets apart[n] to 1 for each pair (i, j) = pairs[n] of corners at the same vertex if they are proven to have only
/// that vertex in common at all t in [0, 1], also if vectors are changed by up to the separation: all vectors of one
/// have dot products with a fixed direction of unit length that are greater than the separation, and those of the other
/// have such products with the opposite direction. Otherwise to 0. The direction is found by approaching the point of
/// the convex hull of all these vectors, one set negated, that is nearest to the origin (Frank and Wolfe 1956).
/// Compiled for each instruction set.
void separate_corners(std::span<const CornerVectors> corners, double separation,
                      std::span<const std::array<std::uint16_t, 2>> pairs, std::uint8_t* apart);

}  // namespace volccd::detail
