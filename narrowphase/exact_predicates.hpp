// Exact answers to single elementary tests, on bare control points: the judge that other narrow phases, filters and
// tests are held against.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <volccd/query/pairs.hpp>

namespace volccd {

/// One elementary test. Features are closed: triangles and edges with their boundary, whatever their extent (an edge or
/// a triangle may be a point).
struct TestMotion {
  FeatureKind kind;
  int control_points;  ///< 2 or 3, of each point's Bezier curve over t in [0,1]
  /// In the order of test_vertices(); each refers to 3 * control_points finite doubles {x, y, z}, {x, y, z}, ...
  std::array<const double*, 4> points;
};

/// How the answer came about.
enum class TouchCase : std::uint8_t {
  apart,     ///< they do not touch
  at_start,  ///< they touch at t = 0
  crossing,  ///< they touch when the four points become coplanar and change sides
  grazing,   ///< they touch when the four points become coplanar without changing sides (a root of even multiplicity)
  coplanar   ///< the four points are coplanar at all times, and the features meet within their plane
};

struct ExactAnswer {
  bool touches = false;
  /// The largest double that is at most the exact first time of contact in [0, t_max]. 0 where they do not touch.
  double toi = 0;
  /// Whether toi is the exact first time.
  bool toi_exact = false;
  /// The four points are coplanar all along, or at the time of contact the triangle has no area or the edges are
  /// parallel (or points). Not looked at where a coordinate axis keeps the features apart.
  bool degenerate = false;
  TouchCase reason = TouchCase::apart;
  /// Sign of det(p1 - p0, p2 - p0, p3 - p0) just before the contact (for t = 0: the motion continued backwards); 0
  /// where it vanishes at all times, or they do not touch.
  int side = 0;
};

/// Decides whether the features touch at some t in [0, t_max], and when first, for every finite input: no tolerance, no
/// overflow, no case left out. Pre: coordinates finite, 0 <= t_max <= 1 (asserted). Allocates; thread-safe. Typical
/// times are in docs/narrowphase_exact.md; they grow with the bits between the greatest and the least coordinate.
ExactAnswer exact_first_touch(const TestMotion& motion, double t_max = 1);

/// Bits of the integers that the coordinates become when all are multiplied by the least power of two that makes them
/// integers: what the time of exact_first_touch() grows with. 0 if all coordinates are 0, at most 2098. O(1).
int coordinate_bits(const TestMotion& motion);

/// Sign of (distance of the features at t) - d: -1, 0 or 1. Pre: t in [0,1], d >= 0 finite.
int compare_distance(const TestMotion& motion, double t, double d);

/// Whether the convex hulls of two sets of points have a point in common: phase one of the simplex method in rationals.
/// An empty set overlaps nothing. Meant for elements: about 0.2 milliseconds for 8 + 8 points.
bool exact_hulls_overlap(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace volccd
