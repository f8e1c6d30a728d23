// Decides whether the convex hulls of two sets of points come within a given distance of each other: exact, and fast in
// clear cases.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/numerics/types.hpp>

namespace volccd::detail {

enum class HullVerdict {
  apart,    ///< proven: a plane keeps them further apart
  overlap,  ///< proven: they come within the distance
  close_call
};

/// Points, and their positions relative to a reference point in rows by axis for the support function.
struct HullPoints {
  std::vector<Vec3> points;
  std::vector<double> rows[3];
  Vec3 low, high;  ///< bounding box of `points`
  Vec3 extent;     ///< greatest |x - reference| on each axis, at least kMinExtent
  Vec3 mean;       ///< mean of x - reference, rounded

  /// Computes the bounding box of `points`.
  void measure();
  /// Computes the rows.
  void refer_to(const Vec3& reference);
};

/// Pairs of vertices of a and b whose differences b - a span the simplex with which a search ended.
struct HullStart {
  int size = 0;
  std::array<std::pair<int, int>, 4> names;
};

/// Gilbert-Johnson-Keerthi algorithm in doubles on {b - a}. The verdicts `apart` and `overlap` are proven for the exact
/// points by the bounds of numerics/rounding.hpp. All other cases are close calls: hulls that touch or are separated by
/// about the rounding error, or coordinates near the limits of the range of doubles. Pre: both sets are non-empty and
/// finite, and their rows have the same reference.
HullVerdict hulls_in_doubles(const HullPoints& a, const HullPoints& b, double distance, HullStart& start);

/// Whether some point of conv(a) and some point of conv(b) are at most `distance` apart, decided with integers: exact
/// for all finite doubles. `start` may contain any vertices, or none. Takes about ten microseconds if the coordinates
/// have similar scales. Allocates memory.
bool hulls_in_integers(std::span<const Vec3> a, std::span<const Vec3> b, double distance, const HullStart& start);

}  // namespace volccd::detail
