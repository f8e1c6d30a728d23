// Value types that every module shares. "Slot" = index of a vertex, element, edge or triangle in its table; slots are
// stable while they are live, and those of removed elements, edges and triangles are used again.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace volccd {

using Index = std::uint32_t;
inline constexpr Index kNone = ~Index{0};

using Vec3 = Eigen::Vector3d;

}  // namespace volccd
