// Whether the convex hulls of two sets of points come within a distance of each other: exact, fast where it is clear.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

enum class HullVerdict {
  apart,    ///< a plane, beyond rounding, keeps them further apart
  overlap,  ///< they come that close, beyond rounding
  close_call
};

/// Points as given, and relative to a reference in rows by axis for the support function.
struct HullPoints {
  std::vector<Vec3> points;
  std::vector<double> rows[3];
  Vec3 low, high;  ///< box of `points`
  Vec3 extent;     ///< greatest |x - reference| on each axis, at least kLeastExtent
  Vec3 mean;       ///< of x - reference, rounded

  /// Box of what is in `points`.
  void measure();
  /// Fills the rows.
  void refer_to(const Vec3& reference);
};

/// Vertices of a and b whose differences b - a span the simplex that a search ended with.
struct HullStart {
  int size = 0;
  std::array<std::pair<int, int>, 4> names;
};

/// Gilbert-Johnson-Keerthi in doubles on {b - a}. `apart` and `overlap` are proven for the exact points, by the bounds
/// of query/rounding.hpp; what they do not decide is a close call: hulls that touch or miss by rounding, or coordinates
/// near the ends of the range of doubles. Pre: both not empty, finite, with the rows of the same reference.
HullVerdict hulls_in_doubles(const HullPoints& a, const HullPoints& b, double distance, HullStart& start);

/// Whether some point of conv(a) and some point of conv(b) are at most `distance` apart, in integers: exact for all
/// finite doubles. `start` may name any vertices, or none. Some ten microseconds where the coordinates have common
/// scale. Allocates.
bool hulls_in_integers(std::span<const Vec3> a, std::span<const Vec3> b, double distance, const HullStart& start);

}  // namespace volccd::detail
