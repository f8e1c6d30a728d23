// Roots of quadratics and cubics in Bernstein form on [0,1].
#pragma once

#include <array>

#include <volccd/narrowphase/detail/coplanarity.hpp>

namespace volccd::detail {

/// Computes the roots in [0,1] of q0 s^2 + 2 q1 s t + q2 t^2, s = 1 - t, in ascending order, and returns their number,
/// 0 to 2. Each has a small relative error both in t and in 1 - t, except for the loss of accuracy near a double root.
/// The zero polynomial has none.
int quadratic_roots(double q0, double q1, double q2, std::array<double, 2>& roots);

/// A partition of [0,1] at the critical points: f is monotone in each [cut[k], cut[k+1]], except for deviations smaller
/// than its rounding bound.
struct MonotonePieces {
  std::array<double, 4> cut;
  int count;
};
MonotonePieces monotone_pieces(const CoplanarityCubic& f);

/// The root of f in [a,b]. Pre: f(a) f(b) < 0, and f is monotone. Newton's method, combined with bisection to remain
/// inside the bracket, until the step vanishes in double precision.
double bracketed_root(const CoplanarityCubic& f, double a, double b);

/// The interval {lo, hi} within a monotone piece [a,b] in which the sign of f is not proven, rounded outward. Pre:
/// there is such an interval.
std::array<double, 2> zero_stretch(const CoplanarityCubic& f, double a, double b);

}  // namespace volccd::detail
