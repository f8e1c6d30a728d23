// Separating axes of two convex pieces in plain doubles: proves that they are disjoint, and measures their penetration
// depth.
#pragma once

#include <volccd/oracle/detail/convex_pieces.hpp>

namespace volccd::detail {

/// Gap of the projections along the best axis found: a lower bound of the distance, valid up to rounding of about 1e-15
/// of the coordinates, whatever the shape of the pieces. Negative: no axis separates them, and minus the value is the
/// penetration depth, the length of the shortest translation that separates them (for pieces with a volume, the axes
/// tried suffice).
double signed_gap(const ConvexPiece& a, const ConvexPiece& b);
/// The same for the convex hulls of two point sets. O(n^3 + n^2 m^2) axes.
double signed_gap(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace volccd::detail
