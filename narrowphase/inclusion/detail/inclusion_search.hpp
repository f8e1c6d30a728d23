// The searches of the `inclusion` narrow phase, for each test that the first passes leave open.
#pragma once

#include <algorithm>
#include <optional>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/numerics/rounding.hpp>
#include <volccd/query/pairs.hpp>

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
  /// `toi` by more than the tolerance, or there were too many intervals, and it is unknown how near the features come
  /// to each other.
  bool unsettled = false;
  /// For a contact with a separation: the closest points then.
  std::optional<ScaledClosestPoints> closest = std::nullopt;
};

/// A division of an interval [lo, hi] of the step into three intervals. Times and their local parameters (0: lo, 1: hi)
/// are rounded. The proof that an outer interval is free of contact must cover it completely up to the inner interval;
/// otherwise some times would be in no interval.
struct Split {
  double from, to;       ///< the inner interval
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

/// Features that have a point in common at t = 0, in equal doubles, touch then. Otherwise searches [0,1] in intervals,
/// in ascending order. Each interval is proven to be free of contact, proven to begin with a contact, or split. The
/// answer is `undecided` if an interval that is shorter than kShortestInterval remains open; the first such interval
/// determines the time. Without a separation, the search then continues, in order to find out whether the first contact
/// may be later. Tests in a plane of constant x, y or z are first searched by their events (detail/flat_motion.hpp).
/// The answer does not depend on t_max, except that later contacts are reported as `apart`. The search ends after
/// `max_intervals` intervals. Pre: tolerance > 0, finite coordinates, separation >= 0.
InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int max_intervals, double t_max);

/// The part of it for tests with a separation: contacts are times at which the distance of two points is certainly
/// less. It may also answer with a contact later than t_max. Pre: separation > 0.
InclusionAnswer separation_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                  double tolerance, int max_intervals, double t_max);

/// Length of an interval, as a fraction of the step, below which it is not split. Features that are closer than their
/// motion in that time count as touching.
inline constexpr double kShortestInterval = 0x1p-44;

}  // namespace volccd::detail
