// The part of space in which contacts are asked for, and the boxes by which a feature pair belongs to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <volccd/query/motion.hpp>

namespace volccd {

/// A closed box, in the unit of the coordinates; empty by default. Bounds may be infinite, but not NaN.
struct MotionBox {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
};

/// Adds the first `control_points` control points of some vertices to a box.
inline void extend(MotionBox& box, const Motion& motion, std::span<const Index> vertices, int control_points) {
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
/// All ranks of a distributed step must use this code, so that they agree bit for bit.
inline double enlarged_low(double low, double separation) {
  return separation == 0 ? low : std::nextafter(low - separation / 2, -std::numeric_limits<double>::infinity());
}
/// An upper bound plus half the separation, rounded upward if there is a separation.
inline double enlarged_high(double high, double separation) {
  return separation == 0 ? high : std::nextafter(high + separation / 2, std::numeric_limits<double>::infinity());
}

/// The box that is greater by half the separation on each side: boxes of features or elements within this distance of
/// each other have a common point.
inline MotionBox enlarged(const MotionBox& box, double separation) {
  MotionBox result;
  for (int i = 0; i < 3; ++i) {
    result.low[i] = enlarged_low(box.low[i], separation);
    result.high[i] = enlarged_high(box.high[i], separation);
  }
  return result;
}

/// The reference point of two features (elements): the lower corner of the common part of their boxes, each around all
/// control points and enlarged by half the separation. From the lower corners before they are enlarged.
inline Vec3 reference_point(const Vec3& low_a, const Vec3& low_b, double separation) {
  Vec3 point;
  for (int i = 0; i < 3; ++i) point[i] = enlarged_low(std::max(low_a[i], low_b[i]), separation);
  return point;
}

/// The points p with low <= p < high on each axis, in the unit of the coordinates. Bounds are infinite where nothing
/// bounds the region; by default it is all of space.
struct Region {
  Vec3 low = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(std::numeric_limits<double>::infinity());

  bool is_all() const {
    constexpr double max = std::numeric_limits<double>::max();
    return low.maxCoeff() < -max && high.minCoeff() > max;
  }
  bool contains(const Vec3& p) const {
    bool inside = true;
    for (int i = 0; i < 3; ++i) inside = inside && low[i] <= p[i] && p[i] < high[i];
    return inside;
  }
  /// Whether all points of the box, which is not empty, are inside.
  bool contains(const MotionBox& box) const { return contains(box.low) && contains(box.high); }
  /// Whether it has a common point with the box, which is not empty.
  bool meets(const MotionBox& box) const {
    bool common = true;
    for (int i = 0; i < 3; ++i) common = common && box.low[i] < high[i] && low[i] <= box.high[i];
    return common;
  }
};

}  // namespace volccd
