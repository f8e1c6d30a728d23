// One elementary test over an interval of the step, with proven bounds on rounding errors: the operations of the
// `inclusion` narrow phase. Derivations: docs/numerics.md, "Intervals of the step".
#pragma once

#include <array>

#include <volccd/narrowphase/inclusion/detail/bounded_test.hpp>

namespace volccd::detail {

/// The test over the interval [lo, hi]: its control points, and the coplanarity polynomial. Holds a reference to the
/// test.
template <int kPoints>
class MotionPiece {
 public:
  static constexpr int kDegree = 3 * (kPoints - 1);

  /// Pre: 0 <= lo <= hi <= 1.
  MotionPiece(const BoundedTest<kPoints>& test, double lo, double hi);

  double lo() const { return lo_; }
  double hi() const { return hi_; }

  /// Computes the Bernstein coefficients of the coplanarity polynomial. True only if they prove that the features are
  /// apart throughout the interval. Must be called before the members that use them.
  bool prove_never_coplanar();
  /// Bernstein coefficients, each times binomial(degree, k), and bounds on their errors.
  const std::array<double, kDegree + 1>& coefficients() const { return b_; }
  double error(int k) const;
  /// Whether no coefficient exceeds its bound; then the polynomial gives no information on this interval or any
  /// interval of it.
  bool vanishes() const;
  /// Sign of the polynomial at the start and end of the interval; 0 if rounding leaves it open.
  int sign_at_start() const;
  int sign_at_end() const;
  /// Local parameter in [0,1] (0: lo, 1: hi) at which contact is most likely, without a proof: the first root if the
  /// signs at the ends differ, otherwise the position where the polynomial is nearest to zero.
  double likely_root() const;

  /// True only if the polynomial proves that the features do not touch before (after) the local parameter s of the
  /// interval.
  bool never_coplanar_before(double s) const;
  bool never_coplanar_after(double s) const;

  /// True only if the projections onto `axis` (any vector) are apart throughout the interval.
  bool separated_along(const Vec3& axis) const;
  /// Bezier points of an axis that turns during the interval. Any vectors; best if the curve is nearly of length 1.
  using AxisCurve = std::array<Vec3, 3>;
  /// True only if the second feature is ahead of the first along the axis, by more than the separation, throughout the
  /// interval.
  bool separated_along_curve(const AxisCurve& axis) const;

  /// Among the differences of control points of the second feature and control points of the first at equal times, the
  /// one with the smallest component along `axis`. Rounded.
  Vec3 support(const Vec3& axis) const;

  /// True only if the projections of the features along `direction` overlap throughout the interval (the vertex is
  /// inside the triangle, or the edges cross). Then each root of the polynomial in this interval is a contact.
  bool overlap_along(const Vec3& direction) const;

  /// A time that is before the first root by less than `tolerance`, or the root itself; negative if no such time can be
  /// proven. `guess`: likely_root(). Pre: the signs at the ends are certain and opposite.
  double before_first_root(double guess, double tolerance) const;

 private:
  using Curve = typename BoundedTest<kPoints>::Curve;
  /// Bernstein coefficients, times binomials, of direction . (e_i x e_j).
  using Quadric = std::array<double, 2 * kPoints - 1>;
  Quadric quadric(const Vec3& direction, std::size_t i, std::size_t j) const;
  double coefficient(int k) const;
  template <bool kBefore>
  bool one_sign(double s) const;
  double value(double s) const;
  double slope(double s) const;
  double value_error() const;

  const BoundedTest<kPoints>& test_;
  double lo_, hi_;
  std::array<Curve, 3> e_;
  std::array<double, kDegree + 1> b_{};
};

}  // namespace volccd::detail

#include <volccd/narrowphase/inclusion/detail/motion_piece-inl.hpp>
