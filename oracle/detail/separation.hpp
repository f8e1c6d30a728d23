// Separating axes of two convex pieces in plain doubles: certifies that they are disjoint, and measures how deep they
// overlap.
#pragma once

#include <volccd/oracle/detail/convex_pieces.hpp>

namespace volccd::detail {

/// Gap of the projections along the best axis found: a lower bound of the distance, valid up to rounding of about 1e-15
/// of the coordinates, whatever the shape of the pieces. Negative: no axis separates them, and minus the value is the
/// depth, the shortest translation that makes them touch (axes are complete for pieces with a volume).
double signed_gap(const ConvexPiece& a, const ConvexPiece& b);
/// The same for the hulls of any points. O(n^3 + n^2 m^2) axes.
double signed_gap(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace volccd::detail
