// The cubic whose roots are the times when the four points of a test are coplanar, with a bound on its rounding error.
#pragma once

#include <array>
#include <cmath>

#include <volccd/narrowphase/detail/moving_points.hpp>
#include <volccd/query/rounding.hpp>

namespace volccd::detail {

/// f(t) = det(d1, d2, d3)(t), di = point i - point 0: six times the volume of the tetrahedron of the four points, for
/// VF and EE alike. In Bernstein form, s = 1 - t:  f = b0 s^3 + b1 s^2 t + b2 s t^2 + b3 t^3 (the binomials are in b).
///
/// Side: VF, (f1-f0) x (f2-f0) . (v - f0) = -f.  EE, (a1-a0) x (b1-b0) . (a0 - b0) = f.
struct CoplanarityCubic {
  std::array<double, 4> b;
  /// |f(t) - exact f(t)| <= error for exact evaluation of these coefficients at any t in [0,1].
  double error;

  double value(double t) const {
    const double s = 1 - t;
    return ((b[0] * s + b[1] * t) * s + b[2] * (t * t)) * s + b[3] * (t * t * t);
  }
  /// |value(t) - exact f(t)| is below this.
  double bound(double t) const {
    const double s = 1 - t;
    const double magnitude =
        ((std::abs(b[0]) * s + std::abs(b[1]) * t) * s + std::abs(b[2]) * (t * t)) * s + std::abs(b[3]) * (t * t * t);
    return error + 14 * kUnitRoundoff * magnitude;
  }
  /// -1 or 1 where the sign of f(t) is proven, else 0.
  int sign(double t) const {
    const double f = value(t), e = bound(t);
    return f > e ? 1 : f < -e ? -1 : 0;
  }
  /// The derivative's Bernstein form: q0 s^2 + 2 q1 s t + q2 t^2.
  std::array<double, 3> derivative_coefficients() const { return {b[1] - 3 * b[0], b[2] - b[1], 3 * b[3] - b[2]}; }
  double derivative(double t) const {
    const double s = 1 - t;
    const std::array<double, 3> q = derivative_coefficients();
    return (q[0] * s + 2 * q[1] * t) * s + q[2] * (t * t);
  }
};

/// Coefficients computed with about 100 bits from the exact coordinates (times `scale`, see range_scale()) and then
/// rounded: `error` is 2^-90 of the permanent of the differences' magnitudes, so that what is left as zero is zero, or
/// as good as. Over the part [lo, hi] of the step: the cubic's parameter is 0 at lo and 1 at hi. A short part in which
/// the points come close to each other has coefficients of their distances then, which a whole step of fast motion
/// would hide.
CoplanarityCubic refined_coplanarity(const TestPoints& x, double scale, double lo = 0, double hi = 1);

}  // namespace volccd::detail
