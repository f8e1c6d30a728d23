// Boxes of moving features and elements, by which ranks decide who holds an element and who tests a feature pair. All
// ranks must use this code, so that they agree bit for bit.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <volccd/query/motion.hpp>

namespace volccd::distributed {

/// A closed box, in the unit of the coordinates; empty by default. Bounds may be infinite, but not NaN.
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
};

/// Adds the first `control_points` control points of some vertices to a box.
inline void extend(Box& box, const Motion& motion, std::span<const Index> vertices, int control_points) {
  for (const Index v : vertices) {
    const double* p = motion.at(v);
    for (int c = 0; c < control_points; ++c, p += 3)
      for (int i = 0; i < 3; ++i) {
        box.low[i] = std::min(box.low[i], p[i]);
        box.high[i] = std::max(box.high[i], p[i]);
      }
  }
}

/// A lower bound less half the separation, rounded downward if there is a separation. Monotone in `low`: the enlarged
/// box of an element contains those of its features, and the maximum of two enlarged bounds is the enlarged maximum.
inline double enlarged_low(double low, double separation) {
  return separation == 0 ? low : std::nextafter(low - separation / 2, -std::numeric_limits<double>::infinity());
}
/// An upper bound plus half the separation, rounded upward if there is a separation.
inline double enlarged_high(double high, double separation) {
  return separation == 0 ? high : std::nextafter(high + separation / 2, std::numeric_limits<double>::infinity());
}

/// The box that is greater by half the separation on each side: boxes of features or elements within this distance of
/// each other have a common point.
inline Box enlarged(const Box& box, double separation) {
  Box result;
  for (int i = 0; i < 3; ++i) {
    result.low[i] = enlarged_low(box.low[i], separation);
    result.high[i] = enlarged_high(box.high[i], separation);
  }
  return result;
}

/// Lower corner of the common part of two boxes, from their lower corners before they are enlarged: the reference point
/// of the two.
inline Vec3 reference_point(const Vec3& low_a, const Vec3& low_b, double separation) {
  Vec3 point;
  for (int i = 0; i < 3; ++i) point[i] = enlarged_low(std::max(low_a[i], low_b[i]), separation);
  return point;
}

}  // namespace volccd::distributed
