// The search of the `inclusion` narrow phase, for each test that the first passes leave open.
#pragma once

#include <algorithm>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/numerics/rounding.hpp>

namespace volccd::detail {

struct InclusionAnswer {
  enum class Outcome {
    apart,     ///< proven not to touch
    touch,     ///< proven to touch
    undecided  ///< the distance is too small for rounded arithmetic to decide, or the search ended early
  } outcome;
  /// First time of contact. It is never late; it is early by at most the tolerance if the features do touch then.
  double toi = 0;
  /// Sign of the coplanarity polynomial before the contact; 0 if it is unknown.
  int side = 0;
  /// Whether the features are not proven to be apart at t = 0.
  bool at_start = false;
  /// For undecided tests: more is open than whether there is a contact. Either a first contact may occur later than
  /// `toi` by more than the tolerance, or there were too many parts, and it is unknown how near the features come to
  /// each other.
  bool unsettled = false;
};

/// A division of a part [lo, hi] of the step into three parts. Times and their local parameters (0: lo, 1: hi) are
/// rounded. The proof that an outer part is free of contact must cover it completely up to the inner part; otherwise
/// some times would be in no part.
struct Split {
  double from, to;       ///< the inner part
  double before, after;  ///< local parameters: `before` is not less than that of `from`, `after` not greater than that
                         ///< of `to`

  /// Divides around the local parameters begin < end. The parameters 0 and 1 give exactly lo and hi, although lo + (hi
  /// - lo) may be rounded to less than hi. Pre: 0 <= lo < hi <= 1.
  Split(double lo, double hi, double begin, double end) {
    const double width = hi - lo;
    from = lo + begin * width;
    to = end < 1 ? std::min(hi, lo + end * width) : hi;
    // Two differences, a quotient and a product: four rounding errors.
    constexpr double kSlack = 8 * kUnitRoundoff;
    before = begin > 0 ? std::min(1.0, (from - lo) / width * (1 + kSlack)) : 0;
    after = end < 1 ? (to - lo) / width * (1 - kSlack) : 1;
  }
};

/// Features that have a point in common at t = 0, in equal doubles, touch then. Otherwise searches [0,1] in parts, in
/// ascending order. Each part is proven to be free of contact, proven to begin with a contact, or split. The answer is
/// `undecided` if a part that is shorter than kShortestPiece remains open; the first such part determines the time.
/// Without a separation, the search then continues, in order to find out whether the first contact may be later. Tests
/// in a plane of constant x, y or z are first searched by their events (detail/flat_motion.hpp). The
/// answer does not depend on t_max, except that later contacts are reported as `apart`. The search ends after
/// `max_pieces` parts. Pre: tolerance > 0, finite coordinates, separation >= 0.
InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int max_pieces, double t_max);

/// Length of a part, as a fraction of the step, below which it is not split. Features that are closer than their motion
/// in that time count as touching.
inline constexpr double kShortestPiece = 0x1p-44;

}  // namespace volccd::detail
