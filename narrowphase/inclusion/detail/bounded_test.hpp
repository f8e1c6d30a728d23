// One elementary test with proven bounds on rounding errors, as the `inclusion` narrow phase takes it. Derivations:
// docs/numerics.md, "Intervals of the step".
#pragma once

#include <array>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Rounded differences of the points of a test to its first point, scaled by a power of two into a safe range, and the
/// magnitudes from which error bounds are computed. kPoints: number of control points, 2 or 3.
template <int kPoints>
class BoundedTest {
 public:
  using Curve = std::array<Vec3, kPoints>;

  /// Pre: coordinates finite, separation >= 0.
  BoundedTest(FeatureKind kind, const TestPoints& x, double separation);

  FeatureKind kind() const { return kind_; }
  double separation() const { return separation_; }  ///< scaled like the differences
  double scale() const { return scale_; }            ///< as in moving_points()
  const std::array<Curve, 3>& differences() const { return differences_; }
  /// Greatest magnitudes over all control points of the points 1, 2, 3; at least kMinExtent.
  const std::array<Vec3, 3>& extents() const { return extents_; }
  const Vec3& extent() const { return extent_; }
  /// Whether no point moves relative to another, according to the rounded differences.
  bool rigid() const { return rigid_; }
  /// The error of Bernstein coefficient k of the coplanarity polynomial over any interval of the step, times
  /// binomial(degree, k), is less than binomial * coplanarity_error() + coplanarity_underflow(). The latter is of the
  /// order of kDeterminantUnderflow.
  double coplanarity_error() const { return coplanarity_error_; }
  double coplanarity_underflow() const { return coplanarity_underflow_; }
  /// Bound on the error of the difference between the distance of closest_points() at any time, which is that of two
  /// points of the features, and the separation.
  double distance_error() const { return distance_error_; }

  /// Differences at time t, rounded.
  Differences at(double t) const;

 private:
  void store_differences(const TestPoints& x, double separation, double scale);
  void measure();

  FeatureKind kind_;
  double separation_ = 0, scale_ = 1;
  std::array<Curve, 3> differences_;
  std::array<Vec3, 3> extents_;
  Vec3 extent_;
  bool rigid_ = false;
  double coplanarity_error_ = 0, coplanarity_underflow_ = 0, distance_error_ = 0;
};

}  // namespace volccd::detail

#include <volccd/narrowphase/inclusion/detail/bounded_test-inl.hpp>
