// The cubic polynomial whose roots are the times at which the four points of a test are coplanar, with a bound on its
// rounding error.
#pragma once

#include <array>
#include <cmath>

#include <volccd/narrowphase/moving_points.hpp>
#include <volccd/numerics/rounding.hpp>

namespace volccd::detail {

/// f(t) = det(d1, d2, d3)(t), where di = point i - point 0: six times the volume of the tetrahedron of the four points,
/// both for VF and EE. In Bernstein form with s = 1 - t, f = b0 s^3 + b1 s^2 t + b2 s t^2 + b3 t^3 (the b include the
/// binomials).
///
/// Sides: VF: (f1-f0) x (f2-f0) . (v - f0) = -f.  EE: (a1-a0) x (b1-b0) . (a0 - b0) = f.
struct CoplanarityCubic {
  std::array<double, 4> b;
  /// |f(t) - exact f(t)| <= error at any t in [0,1] if these coefficients are evaluated exactly.
  double error;

  double value(double t) const {
    const double s = 1 - t;
    return ((b[0] * s + b[1] * t) * s + b[2] * (t * t)) * s + b[3] * (t * t * t);
  }
  /// Upper bound on |value(t) - exact f(t)|.
  double bound(double t) const {
    const double s = 1 - t;
    const double magnitude =
        ((std::abs(b[0]) * s + std::abs(b[1]) * t) * s + std::abs(b[2]) * (t * t)) * s + std::abs(b[3]) * (t * t * t);
    return error + 14 * kUnitRoundoff * magnitude;
  }
  /// Sign of f(t), -1 or 1, if it is proven; otherwise 0.
  int sign(double t) const {
    const double f = value(t), e = bound(t);
    return f > e ? 1 : f < -e ? -1 : 0;
  }
  /// Bernstein form of the derivative: q0 s^2 + 2 q1 s t + q2 t^2.
  std::array<double, 3> derivative_coefficients() const { return {b[1] - 3 * b[0], b[2] - b[1], 3 * b[3] - b[2]}; }
  double derivative(double t) const {
    const double s = 1 - t;
    const std::array<double, 3> q = derivative_coefficients();
    return (q[0] * s + 2 * q[1] * t) * s + q[2] * (t * t);
  }
};

/// Coefficients that are computed with about 100 bits from the exact coordinates (times `scale`, see range_scale()) and
/// then rounded. `error` is 2^-90 of the permanent of the magnitudes of the differences, so that a value that cannot be
/// distinguished from zero is zero for practical purposes. The cubic describes the interval [lo, hi] of the step: its
/// parameter is 0 at lo and 1 at hi. In a short interval in which the points are close to each other, the coefficients
/// are in proportion to these small distances, which the coefficients for a whole step of fast motion cannot resolve.
CoplanarityCubic refined_coplanarity(const TestPoints& x, double scale, double lo = 0, double hi = 1);

}  // namespace volccd::detail
