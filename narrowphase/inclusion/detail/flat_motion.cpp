#include <volccd/narrowphase/inclusion/detail/flat_motion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace volccd::detail {

int flat_axis(const TestPoints& x, int control_points) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool flat = std::all_of(x.begin(), x.end(), [&](const double* point) {
      for (int c = 0; c < control_points; ++c)
        if (point[3 * c + axis] != x[0][axis]) return false;
      return true;
    });
    if (flat) return axis;
  }
  return -1;
}

std::span<const FlatEvent> flat_events(FeatureKind kind) {
  static constexpr std::array<FlatEvent, 3> kVertexAndTriangle{{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
  static constexpr std::array<FlatEvent, 4> kEdges{{{0, 2, 3}, {1, 2, 3}, {2, 0, 1}, {3, 0, 1}}};
  if (kind == FeatureKind::vf) return kVertexAndTriangle;
  return kEdges;
}

DrawnOutEvent::DrawnOutEvent(const FlatEvent& event, const TestPoints& x, int control_points, int axis)
    : points_{ends_[0].data(), ends_[1].data(), x[event.first], x[event.second]} {
  // About the size of the test, so that the edges of the event have similar lengths. Rounding only changes the length.
  constexpr double max = std::numeric_limits<double>::max();
  double length = 0;
  for (int i = 0; i < 3 * control_points; ++i)
    for (const double* point : x) length = std::max(length, std::min(max, std::abs(point[i] - x[0][i % 3])));
  for (std::size_t side = 0; side < 2; ++side) {
    std::copy_n(x[event.vertex], 3 * control_points, ends_[side].begin());
    for (int c = 0; c < control_points; ++c) {
      double& end = ends_[side][static_cast<std::size_t>(3 * c + axis)];
      end = std::clamp(end + (side == 0 ? -length : length), -max, max);
    }
  }
}

}  // namespace volccd::detail
