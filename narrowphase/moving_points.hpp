// The four moving points of one elementary test, relative to the first point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// Pointers to the coordinates of a test: for each point, in the order of test_vertices(), {x, y, z} of each control
/// point. Two control points are the positions at t = 0 and t = 1.
using TestPoints = std::array<const double*, 4>;

inline TestPoints test_points(const Motion& motion, const std::array<Index, 4>& vertices) {
  return {motion.at(vertices[0]), motion.at(vertices[1]), motion.at(vertices[2]), motion.at(vertices[3])};
}

/// Differences of the points 1, 2, 3 and point 0 at one time. VF: the triangle relative to the vertex. EE: the other
/// end of edge 1, and edge 2, relative to the first end of edge 1.
using Differences = std::array<Vec3, 3>;

/// Motion on straight lines.
struct MovingPoints {
  Differences start, end;
  /// Largest magnitude of a coordinate difference, at t = 0 or 1.
  double size;
  /// Largest change of a coordinate difference.
  double travel;

  /// Differences at time t; exact at t = 0 and t = 1.
  Differences at(double t) const {
    const double s = 1 - t;
    return {s * start[0] + t * end[0], s * start[1] + t * end[1], s * start[2] + t * end[2]};
  }
};

/// (a - b) times `scale`, a power of two, rounded. For scale <= 1 the coordinates are scaled before the subtraction,
/// for scale > 1 the difference is scaled, so that no intermediate value overflows unless the result does.
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

/// Motion on quadratic Bezier curves.
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

/// The same as moving_points() for three control points.
CurvedPoints curved_points(const TestPoints& x, double scale);

/// Range of sizes for which products of six lengths neither overflow nor lose digits by underflow.
inline constexpr double kMinSize = 0x1p-100, kGreatestSize = 0x1p100;

/// 1 for points of ordinary size; otherwise the power of two that scales the largest coordinate difference to about 1.
/// Valid also for coordinates whose difference overflows.
double range_scale(const TestPoints& x, int control_points = 2);

}  // namespace volccd::detail
