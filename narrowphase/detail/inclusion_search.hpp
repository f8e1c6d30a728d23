// The search that the `inclusion` narrow phase makes for each test that its first pass leaves open.
#pragma once

#include <algorithm>
#include <array>

#include <volccd/narrowphase/detail/moving_points.hpp>

namespace volccd::detail {

struct InclusionAnswer {
  enum class Outcome {
    apart,     ///< proven
    touch,     ///< proven
    undecided  ///< nearer than rounding can tell, or the search was cut short
  } outcome;
  /// First time of contact: never late; early by at most the tolerance if the features do touch next.
  double toi = 0;
  /// Sign of the coplanarity polynomial before the contact; 0 where it is not known.
  int side = 0;
  /// The features are not proven apart at t = 0.
  bool at_start = false;
  /// Undecided, and of a contact more is open than whether it is one: a first touch may come later than `toi` by more
  /// than the tolerance, or there were too many pieces and how near the features come is not known.
  bool unsettled = false;
};

/// The times at the local parameters `before` < `after` of [lo, hi] (0: lo, 1: hi). At 0 and 1 exactly lo and hi: lo +
/// (hi - lo) may round to less than hi, and what lies between would be nobody's.
inline std::array<double, 2> times_within(double lo, double hi, double before, double after) {
  const double width = hi - lo;
  return {lo + before * width, after < 1 ? std::min(hi, lo + after * width) : hi};
}

/// Looks through [0,1] from left to right in pieces: each is proven free of contact, proven to begin with one, or split.
/// Undecided: a piece stays open that is shorter than kShortestPiece, the first of which gives the time. Without a
/// separation the search goes on from there, to see whether a first touch may be later. The answer does not depend on
/// t_max, but that contacts after it are `apart`. `tolerance` > 0. After `most_pieces` the rest is given up. Pre: finite
/// coordinates, separation >= 0.
InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int most_pieces, double t_max);

/// Of the step. Whatever is closer than it moves meanwhile counts as contact.
inline constexpr double kShortestPiece = 0x1p-44;

}  // namespace volccd::detail
