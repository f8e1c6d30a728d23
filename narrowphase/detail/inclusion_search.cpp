#include <volccd/narrowphase/detail/inclusion_search.hpp>

#include <array>
#include <cassert>

#include <Eigen/Geometry>

#include <volccd/narrowphase/detail/closest_points.hpp>
#include <volccd/narrowphase/detail/double_double.hpp>
#include <volccd/narrowphase/detail/hull_simplex.hpp>
#include <volccd/narrowphase/detail/motion_piece.hpp>
#include <volccd/narrowphase/inclusion.hpp>

namespace volccd::detail {
namespace {

using Outcome = InclusionAnswer::Outcome;

/// A contact shrinks its piece to a quarter a level for so many levels, then to half: both ends soon suffice for a
/// proof, where there is one.
constexpr int kLevelsOfThree = 8;

struct Part {
  double lo, hi;
  int level;
};

/// Parts still to be looked at, the earliest on top. A level leaves at most two behind; from kLevelsOfThree on, parts
/// are halved at each level, down to kShortestPiece.
class PartStack {
 public:
  bool empty() const { return size_ == 0; }
  void push(const Part& part) {
    assert(size_ < parts_.size());
    if (part.lo < part.hi) parts_[size_++] = part;
  }
  Part pop() { return parts_[--size_]; }
  void clear() { size_ = 0; }

 private:
  std::array<Part, 2 * kLevelsOfThree + 64> parts_;
  std::size_t size_ = 0;
};

/// v without its part along e. Twice is enough: the second round corrects what cancellation left in the first.
Vec3 across(Vec3 v, const Vec3& e) {
  const double length = e.squaredNorm();
  if (!(length > 0)) return v;
  for (int round = 0; round < 2; ++round) v -= (v.dot(e) / length) * e;
  return v;
}

/// Direction between the closest points. Their difference is good to a unit of the size, no better, and where it is
/// small, its direction is not: then a plane across it cuts the long features that it should only keep apart. So it is
/// turned to be at right angles to the edges and triangles that the closest points lie within.
Vec3 separating_axis(FeatureKind kind, const Differences& d) {
  const ClosestPoints closest = closest_points(kind, d);
  const std::array<double, 4>& w = closest.weights;
  if (kind == FeatureKind::vf) {
    const Vec3 e01 = d[1] - d[0], e02 = d[2] - d[0], e12 = d[2] - d[1];
    if (w[1] > 0 && w[2] > 0 && w[3] > 0) return across(across(Vec3(e01.cross(e02)), e01), e02);
    if (w[1] > 0 && w[2] > 0) return across(closest.separation, e01);
    if (w[1] > 0 && w[3] > 0) return across(closest.separation, e02);
    if (w[2] > 0 && w[3] > 0) return across(closest.separation, e12);
    return closest.separation;
  }
  const Vec3 &first = d[0], second = d[2] - d[1];
  const bool in_first = w[0] > 0 && w[1] > 0, in_second = w[2] > 0 && w[3] > 0;
  if (in_first && in_second) {
    const Vec3 n = first.cross(second);
    // Parallel edges: any direction across them both.
    return n.squaredNorm() > 0x1p-60 * first.squaredNorm() * second.squaredNorm() ? across(across(n, first), second)
                                                                                  : across(closest.separation, first);
  }
  if (in_first) return across(closest.separation, first);
  if (in_second) return across(closest.separation, second);
  return closest.separation;
}

/// Candidates for the direction between the closest points of features that are nearer than about 2^-26 of their size.
/// Rounding then decides which edges the closest points seem to lie within: the nearest point of a sliver may be a
/// corner while an edge is nearly as close. So each choice of edges that the axis is made perpendicular to is tried.
std::array<Vec3, 5> close_axes(FeatureKind kind, const Differences& d, const Vec3& separation) {
  const bool vf = kind == FeatureKind::vf;
  const Vec3 first = vf ? Vec3(d[1] - d[0]) : d[0], second = d[2] - (vf ? d[0] : d[1]);
  return {separation, across(separation, first), across(separation, second),
          vf ? across(separation, d[2] - d[1]) : across(across(separation, first), second),
          across(across(first.cross(second), first), second)};
}

/// The points keep all their differences: not only as these are rounded.
template <int kPoints>
bool moves_as_one(const TestPoints& x) {
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t j = 3; j < 3 * kPoints; ++j) {
      const DoubleDouble start = exact_difference(x[i][j % 3], x[0][j % 3]), now = exact_difference(x[i][j], x[0][j]);
      if (!(now.high == start.high && now.low == start.low)) return false;
    }
  return true;
}

template <int kPoints>
class PieceSearch {
 public:
  PieceSearch(FeatureKind kind, const TestPoints& x, double separation, double tolerance, int most_pieces)
      : points_(x), test_(kind, x, separation), tolerance_(tolerance), most_pieces_(most_pieces) {}

  InclusionAnswer run(double t_max) {
    stack_.push({0, 1, 0});
    InclusionAnswer open{Outcome::apart};  // the first piece that stays open, if any
    for (int pieces = 0; !stack_.empty(); ++pieces) {
      const Part part = stack_.pop();
      const bool is_open = open.outcome == Outcome::undecided;
      if (!is_open && part.lo > t_max) break;
      if (pieces == most_pieces_) return unsettled(is_open ? open : undecided(part.lo));
      MotionPiece<kPoints> piece(test_, part.lo, part.hi);
      if (piece.never_coplanar() || (moved_apart_ && piece.separated_along(axis_))) continue;
      look(piece);
      if (test_.separation() > 0) {
        if (certainly_within(part.lo)) return touch(part.lo);  // all before is free
        if (certainly_within(part.hi)) {
          if (part.hi - part.lo <= tolerance_) return touch(part.lo);
          if (part.level < kLevelsOfThree && split_at_approach(part)) continue;
        }
      }
      // What matters is decided at the root, and the polynomial tells where that is: a short part at first.
      if (part.level == 0 && crossing(piece)) {
        split_at_root(piece, part, kRootMargin);
        continue;
      }
      if (const InclusionAnswer answer = contact(piece); answer.outcome == Outcome::touch) {
        if (!is_open) return answer;
        return part.hi <= open.toi + tolerance_ ? touch(open.toi) : unsettled(open);
      }
      if (separated(piece, part.level)) continue;
      if (part.hi - part.lo > kShortestPiece && !test_.rigid()) {
        split(piece, part);
        continue;
      }
      if (separated_closely(piece)) continue;
      if (!is_open) open = undecided(part.lo);
      if (test_.separation() > 0 || (test_.rigid() && moves_as_one<kPoints>(points_))) break;
      if (part.hi > open.toi + tolerance_) return unsettled(open);
    }
    return open;
  }

 private:
  /// At the likely time of contact.
  void look(const MotionPiece<kPoints>& piece) {
    root_ = test_.separation() > 0 ? 0.5 : piece.likely_root();
    likely_ = test_.at(piece.lo() + root_ * (piece.hi() - piece.lo()));
  }

  bool separated(const MotionPiece<kPoints>& piece, int level) {
    if (separated_along(separating_axis(test_.kind(), likely_), piece)) return true;
    // Features that stay near each other for long need the best axis there is.
    return (test_.separation() > 0 || level >= kLevelsOfThree) && separated_by_search(piece);
  }

  /// Along the direction to the nearest point of the hull of all differences of the features' control points, which
  /// separates if anything does (Gilbert, Johnson, Keerthi).
  bool separated_by_search(const MotionPiece<kPoints>& piece) {
    constexpr int kMostRounds = 8;
    HullSimplex<double> simplex;
    Vec3 axis = separating_axis(test_.kind(), likely_);
    for (int round = 0; round < kMostRounds; ++round) {
      const Vec3 next = piece.support(axis);
      if (!simplex.add({next.x(), next.y(), next.z()}, {}) || simplex.size == 4) return false;
      axis = {simplex.direction[0], simplex.direction[1], simplex.direction[2]};
      if (separated_along(axis, piece)) return true;
    }
    return false;
  }

  /// Before a part is given up: for features that are further apart than an undecided test may be.
  bool separated_closely(const MotionPiece<kPoints>& piece) {
    const Vec3 between = closest_points(test_.kind(), likely_).separation;
    if (between.norm() - test_.separation() < kUndecidedDistance / 2 * test_.extent().maxCoeff()) return false;
    for (const Vec3& axis : close_axes(test_.kind(), likely_, between))
      if (separated_along(axis, piece)) return true;
    return false;
  }

  bool separated_along(const Vec3& axis, const MotionPiece<kPoints>& piece) {
    if (!piece.separated_along(axis)) return false;
    axis_ = axis;
    moved_apart_ = true;
    return true;
  }

  /// A contact that is certain, without a separation.
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
    if (t == 0) {
      const MotionPiece<kPoints> start(test_, 0, 0);
      answer.at_start = !start.separated_along(separating_axis(test_.kind(), test_.at(0)));
    }
    return answer;
  }

  bool certainly_within(double t) const { return test_.gap(t) < -test_.gap_error(); }

  /// Around the time at which the separation is reached, by false position (an end that stays put counts for half):
  /// closer to it than the tolerance on both sides. Pre: within the separation at the part's end.
  bool split_at_approach(const Part& part) {
    double a = part.lo, b = part.hi, fa = test_.gap(a), fb = test_.gap(b), c = a;
    if (!(fa > 0)) return false;
    for (int round = 0; round < 8; ++round) {
      c = a + (b - a) * (fa / (fa - fb));
      const double fc = test_.gap(c);
      if (std::abs(fc) <= test_.gap_error()) break;
      if (fc > 0) {
        a = c, fa = fc, fb *= 0.5;
      } else {
        b = c, fb = fc, fa *= 0.5;
      }
    }
    const double from = std::max(part.lo, c - tolerance_ / 4), to = std::min(part.hi, c + tolerance_ / 4);
    if (!(from < to)) return false;
    stack_.push({to, part.hi, part.level + 1});
    stack_.push({from, to, part.level + 1});
    stack_.push({part.lo, from, part.level + 1});
    return true;
  }

  void split(const MotionPiece<kPoints>& piece, const Part& part) {
    if (part.level < kLevelsOfThree && crossing(piece)) return split_at_root(piece, part, 0.125);
    const double middle = part.lo + (part.hi - part.lo) / 2;
    stack_.push({middle, part.hi, part.level + 1});
    stack_.push({part.lo, middle, part.level + 1});
  }

  /// The polynomial as it is may settle the outer parts but for a little, which goes with the inner one.
  void split_at_root(const MotionPiece<kPoints>& piece, const Part& part, double margin) {
    const Split split(part.lo, part.hi, std::max(0.0, root_ - margin), std::min(1.0, root_ + margin));
    if (split.to < part.hi && !piece.never_coplanar_after(split.after))
      stack_.push({split.to, part.hi, part.level + 1});
    stack_.push({split.from, split.to, part.level + 1});
    if (part.lo < split.from && !piece.never_coplanar_before(split.before))
      stack_.push({part.lo, split.from, part.level + 1});
  }

  /// The features change sides for certain.
  bool crossing(const MotionPiece<kPoints>& piece) const {
    return test_.separation() == 0 && piece.sign_at_start() * piece.sign_at_end() < 0;
  }

  const TestPoints& points_;
  BoundedTest<kPoints> test_;
  double tolerance_;
  int most_pieces_;
  PartStack stack_;
  bool moved_apart_ = false;  ///< an axis has separated a piece
  Vec3 axis_;                 ///< the last that did
  double root_ = 0;           ///< local parameter at which the piece was looked at
  Differences likely_;        ///< then
};

}  // namespace

InclusionAnswer inclusion_search(FeatureKind kind, const TestPoints& x, int control_points, double separation,
                                 double tolerance, int most_pieces, double t_max) {
  InclusionAnswer answer = control_points == 2 ? PieceSearch<2>(kind, x, separation, tolerance, most_pieces).run(t_max)
                                               : PieceSearch<3>(kind, x, separation, tolerance, most_pieces).run(t_max);
  if (answer.toi > t_max) answer = {InclusionAnswer::Outcome::apart};
  return answer;
}

}  // namespace volccd::detail
