// Exact results of single elementary tests, given by their control points. Other narrow phases, filters and tests are
// compared with them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <volccd/query/pairs.hpp>

namespace volccd {

/// One elementary test. Features are closed: triangles and edges include their boundary and may be degenerate (an edge
/// or a triangle may be a point).
struct TestMotion {
  FeatureKind kind;
  int control_points;  ///< number of control points, 2 or 3, of each point's Bezier curve over t in [0,1]
  /// In the order of test_vertices(). Each pointer refers to 3 * control_points finite doubles {x, y, z}, {x, y, z},
  /// ...
  std::array<const double*, 4> points;
};

/// The kind of contact.
enum class TouchCase : std::uint8_t {
  apart,     ///< they do not touch
  at_start,  ///< they touch at t = 0
  crossing,  ///< they touch when the four points become coplanar and change sides
  grazing,   ///< they touch when the four points become coplanar without changing sides (a root of even multiplicity)
  coplanar,  ///< the four points are coplanar at all times, and the features meet within their plane
  approach   ///< with a separation: their distance decreases to it
};

struct ExactAnswer {
  bool touches = false;
  /// The largest double that is not greater than the exact first time of contact in [0, t_max]; 0 if the features do
  /// not touch.
  double toi = 0;
  /// Whether toi is the exact first time.
  bool toi_exact = false;
  /// Whether the four points are coplanar at all times, or at the time of contact the triangle has no area or the edges
  /// are parallel (or points). Not determined if a coordinate axis separates the features, or with a separation.
  bool degenerate = false;
  TouchCase reason = TouchCase::apart;
  /// Sign of det(p1 - p0, p2 - p0, p3 - p0) just before the contact (for t = 0, with the motion extrapolated
  /// backwards); 0 if the determinant vanishes at all times, if the features do not touch, or with a separation.
  int side = 0;
};

/// Decides whether the features touch at some t in [0, t_max], and finds the first such time; with a separation,
/// whether their distance is at most the separation. Valid for all finite input: there are no tolerances, overflows or
/// special cases. Pre: coordinates are finite, 0 <= t_max <= 1, the separation is finite and >= 0 (asserted).
/// Allocates memory; thread-safe. The time increases with the number of bits between the greatest and the least
/// coordinate (coordinate_bits()): tens of microseconds for ordinary data, up to seconds over the range of doubles.
ExactAnswer exact_first_touch(const TestMotion& motion, double t_max = 1, double separation = 0);

/// Number of bits of the coordinates and the separation when all are multiplied by the least power of two that makes
/// them integers. It determines the time of exact_first_touch(). 0 if all of them are 0, at most 2098. O(1).
int coordinate_bits(const TestMotion& motion, double separation = 0);

/// Sign of (distance of the features at t) - d: -1, 0 or 1. Pre: t in [0,1], d finite and >= 0.
int compare_distance(const TestMotion& motion, double t, double d);

/// Whether the convex hulls of two sets of points have a common point; phase one of the simplex method in rational
/// arithmetic. An empty set overlaps nothing. Intended for elements: about 0.2 milliseconds for 8 + 8 points.
bool exact_hulls_overlap(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace volccd
