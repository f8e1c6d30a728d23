// Signs of the volumes of the cones from the corners of elements over their opposite faces, throughout a step.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Bit i is for the i-th vertex of an element (in node order).
struct ConeSigns {
  std::uint8_t positive = 0, negative = 0;

  bool include(const ConeSigns& b) const { return (b.positive & ~positive) == 0 && (b.negative & ~negative) == 0; }
};

/// The cone of a corner consists of the tetrahedra between the corner and the boundary triangles of the element on the
/// faces that do not contain the corner. All cones of a tetrahedron are the tetrahedron. Sets bit i of
/// signs[o].positive if all tetrahedra of the cone of vertex i are proven to have a positive volume at all t in [0, 1],
/// as in an element that is not inverted and has VTK's node order; of signs[o].negative if all are proven to have a
/// negative volume. For tetrahedra, hexahedra, wedges and pyramids. Shells have no cones and get all bits, other
/// elements and empty slots none.
///
/// With a separation d > 0, the sign is also that of each tetrahedron of the cone with some vertices displaced by w/2,
/// others by -w/2, and the rest not, for any w with |w| <= d (docs/clear_stars.md): no feature of it comes within d
/// of the opposite one.
///
/// For element slots [begin, end). Compiled for each instruction set, with the same results on all of them.
void cone_signs(const Step& step, Index begin, Index end, ConeSigns* signs);

}  // namespace volccd::detail
