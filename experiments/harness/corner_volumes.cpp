#include <volccd/experiments/harness/corner_volumes.hpp>

#include <algorithm>
#include <cassert>

#include <Eigen/Geometry>

#include <volccd/paper2011/provot_test.hpp>
#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd {

namespace {

using Corner = std::array<std::uint8_t, 4>;
constexpr Corner kTetrahedron[] = {{0, 1, 2, 3}};
constexpr Corner kPyramid[] = {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}};
constexpr Corner kWedge[] = {{0, 2, 1, 3}, {1, 0, 2, 4}, {2, 1, 0, 5}, {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}};
constexpr Corner kHexahedron[] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                  {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};

/// The volume at a corner: its value at t = 0, and its least value in [0, 1].
struct VolumeRange {
  double start, min;
};

VolumeRange volume_range(const Corner& corner, std::span<const Index> vertices, const Motion& motion) {
  std::array<reference::MovingPoint<double>, 4> points;
  for (std::size_t i = 0; i < 4; ++i) points[i] = reference::moving_point(motion, vertices[corner[i]]);
  const reference::ProvotCubic<double> volume{reference::RelativeMotion<double>(points)};
  std::array<double, 4> cuts;
  const std::size_t pieces = volume.monotone_pieces(cuts);
  VolumeRange range{volume.d, volume.d};
  for (std::size_t i = 1; i <= pieces; ++i) range.min = std::min(range.min, volume.value(cuts[i]));
  return range;
}

}  // namespace

std::span<const Corner> corner_tetrahedra(ElementType type) {
  switch (type) {
    case ElementType::tetrahedron: return kTetrahedron;
    case ElementType::pyramid: return kPyramid;
    case ElementType::wedge: return kWedge;
    case ElementType::hexahedron: return kHexahedron;
    default: return {};
  }
}

double corner_volume(const Corner& corner, std::span<const Index> vertices, std::span<const Vec3> positions) {
  const Vec3& p = positions[vertices[corner[0]]];
  const auto edge = [&](std::size_t i) { return Vec3(positions[vertices[corner[i]]] - p); };
  return edge(1).dot(edge(2).cross(edge(3)));
}

Inversion inversion(ElementType type, std::span<const Index> vertices, const Motion& motion) {
  assert(motion.control_points() == 2);
  Inversion found = Inversion::none;
  for (const Corner& corner : corner_tetrahedra(type)) {
    const VolumeRange range = volume_range(corner, vertices, motion);
    if (!(range.start > 0)) return Inversion::at_start;
    if (!(range.min > 0)) found = Inversion::during;
  }
  return found;
}

}  // namespace volccd
