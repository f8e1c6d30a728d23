// Tests whose points stay in a plane in which one coordinate is constant, as on a plane of symmetry.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// The axis (0, 1, 2) along which all points have the same coordinate, in equal doubles, at all control points; -1 if
/// there is none. Two or three control points.
int flat_axis(const TestPoints& x, int control_points);

/// In a flat test the coplanarity polynomial is zero and tells nothing about contacts. Unless the features touch at t =
/// 0, their first contact is between a vertex of one of them and an edge of the other, which is called an event. Such
/// an event is the contact of two edges that are not coplanar: the edge, and the vertex drawn out along the flat axis
/// in both directions.
struct FlatEvent {
  std::size_t vertex, first, second;  ///< places of the vertex and of the ends of the edge in the test
};

/// All events of a test: three for a vertex and a triangle, four for two edges.
std::span<const FlatEvent> flat_events(FeatureKind kind);

/// The two edges of an event, as a test of the kind `ee`. Refers to the points of the test from which it was made.
class DrawnOutEvent {
 public:
  /// Pre: flat_axis(x, control_points) == axis.
  DrawnOutEvent(const FlatEvent& event, const TestPoints& x, int control_points, int axis);
  DrawnOutEvent(const DrawnOutEvent&) = delete;
  DrawnOutEvent& operator=(const DrawnOutEvent&) = delete;

  const TestPoints& points() const { return points_; }

 private:
  std::array<std::array<double, 9>, 2> ends_;  ///< of the vertex that is drawn out
  TestPoints points_;
};

}  // namespace volccd::detail
