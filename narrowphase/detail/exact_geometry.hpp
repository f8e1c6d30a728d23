// Coordinates of elementary tests as integers, and vectors of polynomials of t made of them. A common factor, a power
// of two, makes all coordinates integers: signs and times do not depend on it.
#pragma once

#include <array>
#include <span>

#include <volccd/narrowphase/detail/algebraic_time.hpp>
#include <volccd/query/vector3.hpp>
#include <volccd/narrowphase/exact_predicates.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Finite doubles times the least common power of two that makes them integers, in order.
class CommonIntegers {
 public:
  void add(double x);
  void add(std::span<const double> x);
  /// Of all that was added.
  std::vector<Integer> integers() const;

 private:
  std::vector<double> values_;
};

/// A point's curve.
using Curve = Vector3<Polynomial>;

/// Points 0 to 3 as they move relative to point 0, which stays at the origin.
std::array<Curve, 4> relative_curves(const TestMotion& motion);

/// Whether the features touch at time t, given that the four points are coplanar then. `degenerate` becomes true if the
/// triangle has no area or the edges are parallel, points included.
bool coplanar_features_touch(FeatureKind kind, const std::array<Curve, 4>& x, AlgebraicTime& t, bool& degenerate);

/// Polynomials, none of them zero, among whose roots is the first time after 0 at which features that are coplanar all
/// along touch, if they do not at 0.
///
/// Let T > 0 be that time. Where two edges cross properly, or a point is inside a triangle that has an area, they did
/// so just before; so at T an end point e of one feature is on an edge gh of the other. Either e, g, h are not
/// collinear at all times: then all components of (g - e) x (h - e) vanish at T, and not all of them always. Or they
/// are: then e between g and h would be so just before, hence e meets g or h at T, and does not always: g - e or h - e
/// vanishes at T.
std::vector<Polynomial> coplanar_events(FeatureKind kind, const std::array<Curve, 4>& x);

}  // namespace volccd::detail
