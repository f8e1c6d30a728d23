// Value types of all modules. A "slot" is the index of a vertex, element, edge or triangle in its table. It is stable
// while the vertex, element, edge or triangle is live; the slots of removed elements, edges and triangles are reused.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace volccd {

using Index = std::uint32_t;
inline constexpr Index kNone = ~Index{0};

using Vec3 = Eigen::Vector3d;

}  // namespace volccd
