// Coordinates of elementary tests as integers, and vectors of polynomials in t with such coefficients. All coordinates
// are multiplied by a common power of two that makes them integers; signs and times do not depend on it.
#pragma once

#include <array>
#include <span>

#include <volccd/narrowphase/exact/detail/algebraic_time.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/numerics/vector3.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Finite doubles, in order, multiplied by the least common power of two that makes all of them integers.
class CommonIntegers {
 public:
  void add(double x);
  void add(std::span<const double> x);
  /// The integers of all added values.
  std::vector<Integer> integers() const;

 private:
  std::vector<double> values_;
};

/// The trajectory of a point.
using Curve = Vector3<Polynomial>;

struct RelativeCurves {
  std::array<Curve, 4> x;  ///< trajectories of the points 0 to 3 relative to point 0, whose curve is zero
  Integer separation;      ///< in the unit of the curves
};

/// Pre: the separation is finite.
RelativeCurves relative_curves(const TestMotion& motion, double separation = 0);

/// A point of one feature, and an edge of the other one.
struct PointAndEdge {
  std::size_t point, g, h;
};

/// The vertex and the three sides, or the four ends and the other edge.
std::span<const PointAndEdge> points_and_edges(FeatureKind kind);

/// Whether the features touch at time t. Pre: the four points are coplanar at t. `degenerate` becomes true if the
/// triangle has no area, or if the edges are parallel or points.
bool coplanar_features_touch(FeatureKind kind, const std::array<Curve, 4>& x, AlgebraicTime& t, bool& degenerate);

/// Non-zero polynomials that include, among their roots, the first time after 0 at which features that are coplanar at
/// all times touch, if they do not touch at 0.
///
/// Proof. Let T > 0 be that time. If two edges cross in their interiors, or a point is inside a triangle with an area,
/// this also holds just before; therefore, at T an end point e of one feature is on an edge gh of the other. If e, g, h
/// are not collinear at all times, then all components of (g - e) x (h - e) vanish at T, and not all of them are zero
/// polynomials. If they are collinear at all times, e cannot be strictly between g and h at T, because this would hold
/// just before; hence e meets g or h at T, but not at all times, and g - e or h - e vanishes at T.
std::vector<Polynomial> coplanar_events(FeatureKind kind, const std::array<Curve, 4>& x);

}  // namespace volccd::detail
