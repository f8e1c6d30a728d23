// Signs of the volumes of tetrahedra throughout a step.
#pragma once

#include <cstdint>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Sets signs[o], for element slots o in [begin, end), to 1 or -1 if the volume det(v1 - v0, v2 - v0, v3 - v0) of the
/// tetrahedron is proven to be positive or negative at all t in [0, 1], otherwise to 0. With a separation d > 0, the
/// sign is also that of each tetrahedron with some vertices displaced by w/2, others by -w/2, and the rest not, for any
/// w with |w| <= d (docs/boundary_flood.md): no feature of it comes within d of the opposite one. Triangles and empty
/// slots get 1. The mesh has no other elements. Compiled for each instruction set, with the same results on all of
/// them.
void volume_signs(const Step& step, Index begin, Index end, std::int8_t* signs);

}  // namespace volccd::detail
