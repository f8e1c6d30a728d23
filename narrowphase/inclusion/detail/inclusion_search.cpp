#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>

#include <array>
#include <cassert>
#include <optional>

#include <Eigen/Geometry>

#include <volccd/narrowphase/closest_points.hpp>
#include <volccd/narrowphase/inclusion/detail/flat_motion.hpp>
#include <volccd/narrowphase/inclusion/detail/motion_piece.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/numerics/double_double.hpp>
#include <volccd/numerics/hull_simplex.hpp>

namespace volccd::detail {
namespace {

using Outcome = InclusionAnswer::Outcome;

/// For this many levels, the interval with a contact is reduced to a quarter per level, then to a half. The short outer
/// intervals are soon sufficient for a proof, if there is one.
constexpr int kLevelsOfThree = 8;

/// Distance below which features seem to touch, in units of the rounding error of the size, per axis.
constexpr double kTouchUnits = 2;

/// Distance, in shortest intervals, by which the search first looks ahead of the first open interval: a number of
/// intervals that it could also examine one by one.
constexpr double kFewIntervals = 256;
/// The greatest such distance, as a fraction of the allowed number of intervals: more than it could examine one by one,
/// because a shortest interval costs about two.
constexpr double kManyIntervals = 0.6;

struct Interval {
  double lo, hi;
  int level;
};

/// The intervals that remain to be examined, the earliest on top. Each level leaves at most two. From kLevelsOfThree
/// on, intervals are halved at each level, down to kShortestInterval.
class IntervalStack {
 public:
  bool empty() const { return size_ == 0; }
  void push(const Interval& interval) {
    assert(size_ < intervals_.size());
    if (interval.lo < interval.hi) intervals_[size_++] = interval;
  }
  Interval pop() { return intervals_[--size_]; }

 private:
  std::array<Interval, 2 * kLevelsOfThree + 64> intervals_;
  std::size_t size_ = 0;
};

/// Whether all differences of the points are exactly constant, not only after rounding.
template <int kPoints>
bool moves_as_one(const TestPoints& x) {
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t j = 3; j < 3 * kPoints; ++j) {
      const DoubleDouble start = exact_difference(x[i][j % 3], x[0][j % 3]), now = exact_difference(x[i][j], x[0][j]);
      if (!(now.high == start.high && now.low == start.low)) return false;
    }
  return true;
}

/// Whether a point of the first feature and a point of the second have the same coordinates at t = 0. Exact.
bool share_a_point_at_start(FeatureKind kind, const TestPoints& x) {
  const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
  for (std::size_t i = 0; i < second; ++i)
    for (std::size_t j = second; j < 4; ++j)
      if (x[i][0] == x[j][0] && x[i][1] == x[j][1] && x[i][2] == x[j][2]) return true;
  return false;
}

template <int kPoints>
class InclusionSearch {
 public:
  InclusionSearch(FeatureKind kind, const TestPoints& x, double tolerance, int max_intervals)
      : points_(x), test_(kind, x, 0), tolerance_(tolerance), max_intervals_(max_intervals) {}

  /// Whether an axis separates the features at t = 0.
  bool apart_at_start() const {
    const MotionPiece<kPoints> start(test_, 0, 0);
    const Differences d = test_.at(0);
    return start.separated_along(separating_axis(test_.kind(), d, closest_points(test_.kind(), d)));
  }

  InclusionAnswer run(double t_max) {
    InclusionAnswer open{Outcome::apart};  // the first interval that remains open, if any
    stack_.push({0, 1, 0});
    for (; !stack_.empty(); ++examined_) {
      const Interval interval = stack_.pop();
      const bool is_open = open.outcome == Outcome::undecided;
      if (!is_open && interval.lo > t_max) break;
      if (examined_ >= max_intervals_) return unsettled(is_open ? open : undecided(interval.lo));
      MotionPiece<kPoints> piece(test_, interval.lo, interval.hi);
      if (prove_free_at_once(piece)) continue;
      locate_likely_contact(piece);
      // The root decides, and the polynomial determines its position; therefore a short interval around it is examined
      // first.
      if (interval.level == 0 && crossing(piece)) {
        split_at_root(piece, interval, kRootMargin);
        continue;
      }
      if (const InclusionAnswer answer = contact(piece); answer.outcome == Outcome::touch) {
        if (!is_open) return answer;
        return interval.hi <= open.toi + tolerance_ ? touch(open.toi) : unsettled(open);
      }
      const bool splits = interval.hi - interval.lo > kShortestInterval && !test_.rigid();
      if (find_separating_axis(piece, interval.level, splits && !is_open)) continue;
      if (splits) {
        if (is_open || !split_around_touch(piece, interval)) split(piece, interval);
        continue;
      }
      if (try_close_axes(piece)) continue;
      if (test_.rigid() && moves_as_one<kPoints>(points_)) return is_open ? open : undecided(interval.lo);
      if (!is_open) {
        open = undecided(interval.lo);
        if (const auto answer = examine_later_times(open, interval.hi)) return *answer;
      }
      if (interval.hi > open.toi + tolerance_) return unsettled(open);
    }
    return open;
  }

 private:
  /// Two proofs and one estimate for the step after the first open interval, which replace hundreds of intervals.
  /// `open` is the answer for that interval, which ends at hi. No value: the search must continue.
  std::optional<InclusionAnswer> examine_later_times(const InclusionAnswer& open, double hi) {
    const bool moved_apart = moved_apart_;
    const Vec3 axis = axis_;
    if (hi <= open.toi + tolerance_ && prove_rest_free(open.toi, hi)) return open;
    if (check_open_for_long(open.toi)) return unsettled(open);
    moved_apart_ = moved_apart;
    axis_ = axis;
    return std::nullopt;
  }

  /// Whether everything after t, except for the tolerance, is proven free, and the first interval of it easily;
  /// otherwise the search might end without an answer.
  bool prove_rest_free(double t, double hi) {
    const double from = std::max(hi, std::min(t + tolerance_, t + kFewIntervals * kShortestInterval));
    return from >= 1 || (prove_free(from, std::min(1.0, 2 * from - t)) && prove_free(from, 1));
  }

  /// Whether intervals after t seem to remain open for longer than the tolerance, or to be more than the search may
  /// examine. This is not certain: if it is wrong, `exact` decides a test that the search could have decided.
  bool check_open_for_long(double t) {
    const double many = std::min(1.5 * tolerance_, kManyIntervals * max_intervals_ * kShortestInterval);
    for (const double after : {many, many / 2, many / 4, many / 8}) {
      // If the features separate slowly, longer intervals are easier to prove free; if they touch again, shorter
      // intervals are.
      for (double length = kShortestInterval; length <= after; length *= 2) {
        const double later = t + std::floor(after / length) * length;
        if (later + length > 1 || !check_open(later, later + length)) return false;
      }
      if (always_coplanar()) break;
    }
    return true;
  }

  bool always_coplanar() const {
    MotionPiece<kPoints> step(test_, 0, 1);
    return !step.prove_never_coplanar() && step.vanishes();
  }

  bool prove_free(double lo, double hi) {
    MotionPiece<kPoints> piece(test_, lo, hi);
    if (prove_free_at_once(piece)) return true;
    locate_likely_contact(piece);
    return find_separating_axis(piece, kLevelsOfThree, false);
  }

  /// Whether no proof succeeds for the interval.
  bool check_open(double lo, double hi) {
    MotionPiece<kPoints> piece(test_, lo, hi);
    if (prove_free_at_once(piece)) return false;
    locate_likely_contact(piece);
    return contact(piece).outcome != Outcome::touch && !find_separating_axis(piece, kLevelsOfThree, false) &&
           !try_close_axes(piece);
  }

  bool prove_free_at_once(MotionPiece<kPoints>& piece) const {
    return piece.prove_never_coplanar() || (moved_apart_ && piece.separated_along(axis_));
  }

  /// Computes the closest points at the likely time of contact.
  void locate_likely_contact(const MotionPiece<kPoints>& piece) {
    root_ = piece.likely_root();
    likely_ = test_.at(piece.lo() + root_ * (piece.hi() - piece.lo()));
  }

  /// Features that remain close to each other for long require the best possible axis. If they seem to touch, there is
  /// none, and an interval that can be split does not require it.
  bool find_separating_axis(const MotionPiece<kPoints>& piece, int level, bool can_split) {
    closest_ = closest_points(test_.kind(), likely_);
    const Vec3 axis = separating_axis(test_.kind(), likely_, closest_);
    if (try_axis(axis, piece)) return true;
    return level >= kLevelsOfThree && !(can_split && seem_to_touch(closest_)) && search_separating_axis(axis, piece);
  }

  /// Whether the points are so near that the features may touch, considering rounding errors.
  bool seem_to_touch(const ClosestPoints& closest) const {
    return (closest.separation.cwiseAbs().array() <= kTouchUnits * kUnitRoundoff * test_.extent().array()).all();
  }

  /// Tests the direction to the nearest point of the hull of all differences of the features' control points, which
  /// separates if any axis does (Gilbert, Johnson, Keerthi).
  bool search_separating_axis(Vec3 axis, const MotionPiece<kPoints>& piece) {
    constexpr int kMaxRounds = 8;
    HullSimplex<double> simplex;
    for (int round = 0; round < kMaxRounds; ++round) {
      const Vec3 next = piece.support(axis);
      if (!simplex.add({next.x(), next.y(), next.z()}, {}) || simplex.size == 4) return false;
      axis = {simplex.direction[0], simplex.direction[1], simplex.direction[2]};
      if (try_axis(axis, piece)) return true;
    }
    return false;
  }

  /// Last test before an interval remains open, for features that are further apart than those of an undecided test may
  /// be.
  bool try_close_axes(const MotionPiece<kPoints>& piece) {
    const Vec3& between = closest_.separation;
    if (between.norm() < kUndecidedDistance / 2 * test_.extent().maxCoeff()) return false;
    for (const Vec3& axis : close_axes(test_.kind(), likely_, between))
      if (try_axis(axis, piece)) return true;
    return false;
  }

  bool try_axis(const Vec3& axis, const MotionPiece<kPoints>& piece) {
    if (!piece.separated_along(axis)) return false;
    axis_ = axis;
    moved_apart_ = true;
    return true;
  }

  /// The answer for a certain contact.
  InclusionAnswer contact(const MotionPiece<kPoints>& piece) const {
    InclusionAnswer answer{Outcome::apart};
    if (!crossing(piece)) return answer;
    const Differences& d = likely_;
    const Vec3 across =
        test_.kind() == FeatureKind::vf ? Vec3((d[1] - d[0]).cross(d[2] - d[0])) : Vec3(d[0].cross(d[2] - d[1]));
    if (!piece.overlap_along(across)) return answer;
    const double t = piece.before_first_root(root_, tolerance_);
    if (t < 0) return answer;
    answer.outcome = Outcome::touch;
    answer.toi = t;
    answer.side = piece.sign_at_start();
    return answer;
  }

  static InclusionAnswer unsettled(InclusionAnswer open) {
    open.outcome = Outcome::undecided;
    open.unsettled = true;
    return open;
  }
  InclusionAnswer undecided(double t) const { return found(Outcome::undecided, t); }
  InclusionAnswer touch(double t) const { return found(Outcome::touch, t); }
  InclusionAnswer found(Outcome outcome, double t) const {
    InclusionAnswer answer{outcome};
    answer.toi = t;
    answer.at_start = t == 0 && !apart_at_start();
    return answer;
  }

  /// Splits an interval around a likely time of contact down to the shortest interval, because no interval that
  /// contains a contact can be proven free. Returns false, without a change, if there seems to be no such time.
  bool split_around_touch(const MotionPiece<kPoints>& piece, const Interval& interval) {
    if (interval.level < kLevelsOfThree && crossing(piece)) return false;
    double t = interval.lo + root_ * (interval.hi - interval.lo);
    if (piece.vanishes() ? !find_touch(interval, t) : !seem_to_touch(closest_)) return false;
    stack_.push(split_down_to(interval, t));
    return true;
  }

  /// Halves the interval until the half that contains t is sufficiently short, and returns it; then all earlier halves
  /// are proven free. If an earlier half is not proven free at once, it is returned instead, and the half that contains
  /// t is pushed. Pushes all later halves. Counts the intervals that a search by splitting would examine.
  Interval split_down_to(Interval interval, double t) {
    Interval shortest = interval;
    while (shortest.hi - shortest.lo > kShortestInterval) {
      const double middle = shortest.lo + (shortest.hi - shortest.lo) / 2;
      (t < middle ? shortest.hi : shortest.lo) = middle;
    }
    const auto clear = [&](double lo, double hi) {
      MotionPiece<kPoints> before(test_, lo, hi);
      return prove_free_at_once(before);
    };
    const bool clear_before = interval.lo == shortest.lo || clear(interval.lo, shortest.lo);
    for (; interval.hi - interval.lo > kShortestInterval; ++examined_) {
      const double middle = interval.lo + (interval.hi - interval.lo) / 2;
      const Interval left{interval.lo, middle, interval.level + 1}, right{middle, interval.hi, interval.level + 1};
      if (t >= middle && !clear_before && !clear(left.lo, left.hi)) {
        stack_.push(right);
        return left;
      }
      if (t < middle)
        stack_.push(right);
      else
        ++examined_;
      interval = t < middle ? left : right;
    }
    return interval;
  }

  /// The first time in the interval at which the features seem to touch, found by Newton's method on their distance,
  /// and by halving. Not certain. Returns false if none is found.
  bool find_touch(const Interval& interval, double& t) const {
    constexpr int kMaxRounds = 16;
    double before = interval.lo;
    t = interval.lo;
    for (int round = 0; round < kMaxRounds; ++round) {
      const ClosestPoints closest = closest_points(test_.kind(), test_.at(t));
      if (seem_to_touch(closest)) {
        while (t - before > kShortestInterval / 4) {
          const double middle = before + (t - before) / 2;
          (seem_to_touch(closest_points(test_.kind(), test_.at(middle))) ? t : before) = middle;
        }
        return true;
      }
      // The same two points at the end of the interval; for two control points their difference is linear in time.
      const Vec3 end = separation_of(test_.kind(), test_.at(interval.hi), closest.weights);
      const double approach = closest.separation.dot(closest.separation - end);
      before = t;
      t += (interval.hi - t) * (closest.squared_distance / approach);
      if (!(approach > 0 && t <= interval.hi)) return false;
    }
    return false;
  }

  void split(const MotionPiece<kPoints>& piece, const Interval& interval) {
    if (interval.level < kLevelsOfThree && crossing(piece)) return split_at_root(piece, interval, 0.125);
    const double middle = interval.lo + (interval.hi - interval.lo) / 2;
    stack_.push({middle, interval.hi, interval.level + 1});
    stack_.push({interval.lo, middle, interval.level + 1});
  }

  /// Splits the interval around the root; the polynomial itself may prove the outer intervals free, except for a margin
  /// that belongs to the inner interval.
  void split_at_root(const MotionPiece<kPoints>& piece, const Interval& interval, double margin) {
    const Split split(interval.lo, interval.hi, std::max(0.0, root_ - margin), std::min(1.0, root_ + margin));
    if (split.to < interval.hi && !piece.never_coplanar_after(split.after))
      stack_.push({split.to, interval.hi, interval.level + 1});
    stack_.push({split.from, split.to, interval.level + 1});
    if (interval.lo < split.from && !piece.never_coplanar_before(split.before))
      stack_.push({interval.lo, split.from, interval.level + 1});
  }

  /// Whether the features certainly change sides.
  bool crossing(const MotionPiece<kPoints>& piece) const { return piece.sign_at_start() * piece.sign_at_end() < 0; }

  const TestPoints& points_;
  BoundedTest<kPoints> test_;
  double tolerance_;
  int max_intervals_;
  int examined_ = 0;  ///< number of intervals examined
  IntervalStack stack_;
  bool moved_apart_ = false;  ///< whether an axis has separated an interval
  Vec3 axis_ = Vec3::Zero();  ///< the last axis that separated an interval
  double root_ = 0;           ///< local parameter at which the interval was examined
  Differences likely_;        ///< differences at that time
  ClosestPoints closest_;     ///< closest points at that time
};

/// The earliest event of a flat test. No value if the features are not certainly apart at t = 0, or if an event remains
/// undecided that may be the first one.
template <int kPoints>
std::optional<InclusionAnswer> flat_search(FeatureKind kind, const TestPoints& x, int axis, double tolerance,
                                           int max_intervals) {
  if (!InclusionSearch<kPoints>(kind, x, tolerance, max_intervals).apart_at_start()) return std::nullopt;
  InclusionAnswer first{Outcome::apart};
  double open = kInfinity, latest = 1;
  for (const FlatEvent& event : flat_events(kind)) {
    const DrawnOutEvent edges(event, x, kPoints, axis);
    const InclusionAnswer answer =
        InclusionSearch<kPoints>(FeatureKind::ee, edges.points(), tolerance, max_intervals).run(latest);
    if (answer.outcome == Outcome::undecided) open = std::min(open, answer.toi);
    if (answer.outcome != Outcome::touch || answer.toi > latest) continue;
    first = {.outcome = Outcome::touch, .toi = answer.toi};
    latest = answer.toi;
  }
  if (open <= latest) return std::nullopt;
  return first;
}

template <int kPoints>
InclusionAnswer touch_search(FeatureKind kind, const TestPoints& x, double tolerance, int max_intervals, double t_max) {
  const int axis = flat_axis(x, kPoints);
  if (axis >= 0)
    if (const auto answer = flat_search<kPoints>(kind, x, axis, tolerance, max_intervals)) return *answer;
  return InclusionSearch<kPoints>(kind, x, tolerance, max_intervals).run(t_max);
}

InclusionAnswer search(FeatureKind kind, const TestPoints& x, int control_points, double separation, double tolerance,
                       int max_intervals, double t_max) {
  if (share_a_point_at_start(kind, x)) return {.outcome = Outcome::touch, .at_start = true};
  if (separation > 0) return separation_search(kind, x, control_points, separation, tolerance, max_intervals, t_max);
  return control_points == 2 ? touch_search<2>(kind, x, tolerance, max_intervals, t_max)
                             : touch_search<3>(kind, x, tolerance, max_intervals, t_max);
}

}  // namespace

InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int max_intervals, double t_max) {
  InclusionAnswer answer = search(kind, x, control_points, separation, tolerance, max_intervals, t_max);
  if (answer.toi > t_max) answer = {Outcome::apart};
  return answer;
}

}  // namespace volccd::detail
