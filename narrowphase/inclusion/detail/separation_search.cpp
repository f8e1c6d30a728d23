#include <array>
#include <cassert>
#include <cmath>

#include <volccd/narrowphase/closest_points.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/detail/motion_piece.hpp>

namespace volccd::detail {
namespace {

using Outcome = InclusionAnswer::Outcome;

/// How often the search looks for the time of the approach; then it halves intervals.
constexpr int kMaxApproaches = 8;

/// Examines intervals from left to right. Each is proven free of contact by an axis that turns, begins with a contact
/// if it is no longer than the tolerance and two points are within the separation at its end, or is split.
template <int kPoints>
class SeparationSearch {
 public:
  SeparationSearch(FeatureKind kind, const TestPoints& x, double separation, double tolerance, int max_intervals)
      : points_(x),
        separation_(separation),
        test_(kind, x, separation),
        tolerance_(tolerance),
        max_intervals_(max_intervals) {}

  InclusionAnswer run(double t_max) {
    front_ = at(0);
    if (certainly_within(front_)) return touch(true);
    push(at(1));
    for (int examined = 0; size_ > 0 && front_.t <= t_max; ++examined) {
      if (examined >= max_intervals_) return undecided();
      const Moment& end = ends_[size_ - 1];
      const double length = end.t - front_.t;
      const bool within = certainly_within(end);
      if (within && length <= tolerance_) return touch(is_at_start());
      if (within && split_at_approach(end)) continue;
      const Moment middle = at(front_.t + length / 2);
      if (!within && !certainly_within(middle) && apart(middle, end)) {
        front_ = end;
        --size_;
        continue;
      }
      if (length <= kShortestInterval || test_.rigid()) return undecided();
      push(middle);
    }
    return {.outcome = Outcome::apart};
  }

 private:
  /// The features at one time.
  struct Moment {
    double t;
    Differences differences;
    ClosestPoints closest;
    double gap;  ///< distance minus the separation, up to distance_error()
  };

  Moment at(double t) const {
    Moment m;
    m.t = t;
    m.differences = test_.at(t);
    m.closest = closest_points(test_.kind(), m.differences);
    m.gap = std::sqrt(m.closest.squared_distance) - test_.separation();
    return m;
  }

  bool certainly_within(const Moment& m) const { return m.gap < -test_.distance_error(); }

  void push(const Moment& end) {
    assert(size_ < ends_.size());
    ends_[size_++] = end;
  }

  InclusionAnswer touch(bool at_start) const {
    return {.outcome = Outcome::touch,
            .toi = front_.t,
            .at_start = at_start,
            .closest = ScaledClosestPoints{front_.closest, test_.extent().maxCoeff(), test_.scale()}};
  }
  InclusionAnswer undecided() const {
    return {.outcome = Outcome::undecided, .toi = front_.t, .at_start = is_at_start(), .unsettled = true};
  }
  bool is_at_start() const {
    return front_.t == 0 && compare_distance({test_.kind(), kPoints, points_}, 0, separation_) <= 0;
  }

  /// The unit vector between the closest points, towards the second feature.
  Vec3 direction(const Moment& m) const {
    const Vec3 axis = separating_axis(test_.kind(), m.differences, m.closest);
    return axis * ((axis.dot(m.closest.separation) > 0 ? -1 : 1) / axis.norm());
  }

  /// Whether an axis separates the features from the front to the end. It turns as the direction between the closest
  /// points does, because features that keep close to each other while they turn have no fixed one for long.
  bool apart(const Moment& middle, const Moment& end) const {
    const Vec3 first = direction(front_), last = direction(end);
    const Vec3 control = 2 * direction(middle) - 0.5 * (first + last);
    return MotionPiece<kPoints>(test_, front_.t, end.t).separated_along_curve({first, control, last});
  }

  /// Splits the interval around the time at which the distance reaches the separation, found by false position
  /// (Illinois method). The inner interval is shorter than the tolerance, and extends further to the later side: there
  /// the features have to be within the separation by more than the error of the distance. Pre: the features are within
  /// the separation at the end of the interval.
  bool split_at_approach(const Moment& end) {
    if (approaches_ == kMaxApproaches || !(front_.gap > 0)) return false;
    ++approaches_;
    constexpr int kMaxRounds = 24;
    double a = front_.t, b = end.t, fa = front_.gap, fb = end.gap, c = a;
    for (int round = 0; round < kMaxRounds && b - a > tolerance_ / 16; ++round) {
      c = a + (b - a) * (fa / (fa - fb));
      const double fc = at(c).gap;
      if (std::abs(fc) <= test_.distance_error() / 64) break;
      if (fc > 0) {
        a = c, fa = fc, fb *= 0.5;
      } else {
        b = c, fb = fc, fa *= 0.5;
      }
    }
    const double from = c - tolerance_ / 4, to = c + 5 * tolerance_ / 8;
    const bool splits_before = from > front_.t, splits_after = to < end.t;
    if (splits_after) push(at(to));
    if (splits_before) push(at(from));
    return splits_before || splits_after;
  }

  const TestPoints& points_;
  double separation_;  ///< as given; that of test_ is scaled and rounded up
  BoundedTest<kPoints> test_;
  double tolerance_;
  int max_intervals_;
  int approaches_ = 0;
  Moment front_;  ///< up to here the features are proven to be further apart than the separation
  /// Ends of the intervals that remain, the earliest last. Each is the end of a half of the interval before it, down to
  /// kShortestInterval, or one of two in split_at_approach().
  std::array<Moment, 48 + 2 * kMaxApproaches> ends_;
  std::size_t size_ = 0;
};

}  // namespace

InclusionAnswer separation_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                  double tolerance, int max_intervals, double t_max) {
  if (control_points == 2) return SeparationSearch<2>(kind, x, separation, tolerance, max_intervals).run(t_max);
  return SeparationSearch<3>(kind, x, separation, tolerance, max_intervals).run(t_max);
}

}  // namespace volccd::detail
