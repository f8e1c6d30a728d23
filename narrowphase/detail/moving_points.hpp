// The four points of one elementary test in motion, relative to the first of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Where a test's coordinates are: for each point, in the order of test_vertices(), {x, y, z} of each control point; of
/// two, t = 0 and t = 1.
using TestPoints = std::array<const double*, 4>;

/// Differences to the first point at one time: point 1, 2, 3. VF: the triangle seen from the vertex. EE: the far end of
/// edge 1, and edge 2, seen from the near end of edge 1.
using Differences = std::array<Vec3, 3>;

/// On straight lines.
struct MovingPoints {
  Differences start, end;
  /// Largest coordinate difference, at t = 0 or 1.
  double size;
  /// Largest change of a coordinate difference.
  double travel;

  /// Exact at t = 0 and t = 1.
  Differences at(double t) const {
    const double s = 1 - t;
    return {s * start[0] + t * end[0], s * start[1] + t * end[1], s * start[2] + t * end[2]};
  }
};

/// (a - b) times `scale`, a power of two, rounded: large coordinates are scaled down first, small differences of large
/// coordinates up last, so that neither step overflows where the result does not.
inline double scaled_difference(double a, double b, double scale) {
  return scale > 1 ? scale * (a - b) : scale * a - scale * b;
}

/// Rounded differences of the coordinates times `scale`, a power of two that keeps them in range.
inline MovingPoints moving_points(const TestPoints& x, double scale) {
  MovingPoints points;
  points.size = points.travel = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const double a = scaled_difference(x[i + 1][k], x[0][k], scale),
                   b = scaled_difference(x[i + 1][k + 3], x[0][k + 3], scale);
      points.start[i][k] = a;
      points.end[i][k] = b;
      points.size = std::max({points.size, std::abs(a), std::abs(b)});
      points.travel = std::max(points.travel, std::abs(b - a));
    }
  return points;
}

/// On quadratic Bezier curves.
struct CurvedPoints {
  Differences start, middle, end;
  /// Largest coordinate difference of control points.
  double size;

  Differences at(double t) const {
    const double s = 1 - t;
    Differences d;
    for (std::size_t i = 0; i < 3; ++i) d[i] = s * (s * start[i] + t * middle[i]) + t * (s * middle[i] + t * end[i]);
    return d;
  }
};

/// As moving_points(), for three control points.
CurvedPoints curved_points(const TestPoints& x, double scale);

/// Sizes for which products of six lengths neither overflow nor lose digits to underflow.
inline constexpr double kLeastSize = 0x1p-100, kGreatestSize = 0x1p100;

/// 1 for points of ordinary size; else the power of two that brings the largest coordinate difference near 1.
/// Coordinates so far apart that their difference overflows are included.
double range_scale(const TestPoints& x, int control_points = 2);

}  // namespace volccd::detail
