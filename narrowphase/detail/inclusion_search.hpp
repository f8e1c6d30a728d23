// The search that the `inclusion` narrow phase makes for each test that its first pass leaves open.
#pragma once

#include <algorithm>

#include <volccd/narrowphase/detail/moving_points.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/rounding.hpp>

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

/// Where a part [lo, hi] of the step is split in three. Times and their local parameters (0: lo, 1: hi) are rounded.
/// The proof that an outer part is free of contact must reach at least to the inner part; otherwise no part would cover
/// the moments between them.
struct Split {
  double from, to;       ///< the inner part
  double before, after;  ///< local parameters: `before` is not below that of `from`, `after` not above that of `to`

  /// Around the local parameters begin < end. Ends at 0 and 1 give exactly lo and hi, though lo + (hi - lo) may round
  /// to less than hi. Pre: 0 <= lo < hi <= 1.
  Split(double lo, double hi, double begin, double end) {
    const double width = hi - lo;
    from = lo + begin * width;
    to = end < 1 ? std::min(hi, lo + end * width) : hi;
    // Two differences, a quotient, a product: four roundings.
    constexpr double kSlack = 8 * kUnitRoundoff;
    before = begin > 0 ? std::min(1.0, (from - lo) / width * (1 + kSlack)) : 0;
    after = end < 1 ? (to - lo) / width * (1 - kSlack) : 1;
  }
};

/// Looks through [0,1] from left to right in pieces: each is proven free of contact, proven to begin with one, or
/// split. Features with a point in common at t = 0, the same doubles, touch then, without a search. Undecided: a piece
/// stays open that is shorter than kShortestPiece, the first of which gives the time. Without a separation the search
/// goes on from there, to see whether a first touch may be later. The answer does not depend on t_max, but that
/// contacts after it are `apart`. `tolerance` > 0. After `most_pieces` the rest is given up. Pre: finite coordinates,
/// separation >= 0.
InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int most_pieces, double t_max);

/// Of the step. Whatever is closer than it moves meanwhile counts as contact.
inline constexpr double kShortestPiece = 0x1p-44;

}  // namespace volccd::detail
