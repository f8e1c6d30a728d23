// One elementary test over a part of the step, with proven bounds on what rounding does: the steps that the `inclusion`
// narrow phase is made of. Derivations: docs/numerics.md, "Parts of the step".
#pragma once

#include <array>

#include <volccd/narrowphase/detail/moving_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Rounded differences of a test's points to the first of them, scaled by a power of two into range, and the magnitudes
/// that error bounds are made of. kPoints control points: 2 or 3.
template <int kPoints>
class BoundedTest {
 public:
  using Curve = std::array<Vec3, kPoints>;

  /// Pre: coordinates finite, separation >= 0.
  BoundedTest(FeatureKind kind, const TestPoints& x, double separation);

  FeatureKind kind() const { return kind_; }
  double separation() const { return separation_; }  ///< scaled
  const std::array<Curve, 3>& differences() const { return differences_; }
  /// Over all control points of points 1, 2, 3; at least kLeastExtent.
  const std::array<Vec3, 3>& extents() const { return extents_; }
  const Vec3& extent() const { return extent_; }
  /// No point moves relative to another, as far as rounded differences tell.
  bool rigid() const { return rigid_; }
  /// Bernstein coefficient k of the coplanarity polynomial over any part of the step, times binomial(degree, k), is off
  /// by less than binomial * coplanarity_error + kDeterminantUnderflow-sized `coplanarity_underflow`.
  double coplanarity_error() const { return coplanarity_error_; }
  double coplanarity_underflow() const { return coplanarity_underflow_; }
  /// Of the polynomial, at any time when the features are within the separation.
  double coplanarity_within_separation() const { return coplanarity_within_separation_; }

  /// At time t, rounded.
  Differences at(double t) const;

  /// Distance of the features at time t less the separation, off by less than gap_error().
  double gap(double t) const;
  double gap_error() const { return gap_error_; }

 private:
  void take(const TestPoints& x, double separation, double scale);
  void measure();

  FeatureKind kind_;
  double separation_ = 0;
  std::array<Curve, 3> differences_;
  std::array<Vec3, 3> extents_;
  Vec3 extent_;
  bool rigid_ = false;
  double coplanarity_error_ = 0, coplanarity_underflow_ = 0, coplanarity_within_separation_ = 0, gap_error_ = 0;
};

/// The test over [lo, hi]: control points there, and the coplanarity polynomial. Refers to the test.
template <int kPoints>
class MotionPiece {
 public:
  static constexpr int kDegree = 3 * (kPoints - 1);

  /// Pre: 0 <= lo <= hi <= 1.
  MotionPiece(const BoundedTest<kPoints>& test, double lo, double hi);

  double lo() const { return lo_; }
  double hi() const { return hi_; }

  /// Computes the Bernstein coefficients of the coplanarity polynomial. True only if they prove that the features are
  /// further apart than the separation all through the piece. Call before what follows.
  bool never_coplanar();
  /// Bernstein coefficients, each times binomial(degree, k), and bounds on their errors.
  const std::array<double, kDegree + 1>& coefficients() const { return b_; }
  double error(int k) const;
  /// No coefficient is beyond its bound: neither here nor in a part does the polynomial tell anything.
  bool vanishes() const;
  /// Sign of the polynomial at the piece's start and end; 0 where rounding leaves it open.
  int sign_at_start() const;
  int sign_at_end() const;
  /// Local parameter in [0,1] (0: lo, 1: hi), not certain, at which contact is most likely: the first root if the signs
  /// at the ends differ, else where the polynomial comes nearest to zero.
  double likely_root() const;

  /// True only if the polynomial proves that the features do not touch in the part of the piece up to (from) the local
  /// parameter s. Pre: no separation.
  bool never_coplanar_before(double s) const;
  bool never_coplanar_after(double s) const;

  /// True only if the projections onto `axis` (any vector) stay further apart than the separation all through the
  /// piece.
  bool separated_along(const Vec3& axis) const;

  /// Of the differences of the second feature's control points to those of the first, at equal times, the least along
  /// `axis`. Rounded.
  Vec3 support(const Vec3& axis) const;

  /// True only if, seen along `direction`, the features overlap all through the piece (vertex inside the triangle,
  /// edges crossing): then each root of the polynomial in it is a contact.
  bool overlap_along(const Vec3& direction) const;

  /// Given that the signs at the ends are certain and opposite: a time before the first root by less than `tolerance`,
  /// or that root; negative if that cannot be told. `guess`: likely_root().
  double before_first_root(double guess, double tolerance) const;

 private:
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
  std::array<std::array<Vec3, kPoints>, 3> e_;
  std::array<double, kDegree + 1> b_{};
};

}  // namespace volccd::detail

#include <volccd/narrowphase/detail/motion_piece-inl.hpp>
