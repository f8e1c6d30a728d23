// Signs of the volumes of tetrahedra all through a step.
#pragma once

#include <cstdint>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// signs[o], for element slots o in [begin, end): 1 or -1 if the volume det(v1 - v0, v2 - v0, v3 - v0) of the
/// tetrahedron is proven positive, or negative, at all t in [0, 1]; else 0. 1 for triangles and empty slots. The mesh
/// has no other elements. Compiled for each instruction set; the same results on all of them.
void volume_signs(const Step& step, Index begin, Index end, std::int8_t* signs);

}  // namespace volccd::detail
