// Roots of quadratics and cubics in Bernstein form on [0,1].
#pragma once

#include <array>

#include <volccd/narrowphase/detail/coplanarity.hpp>

namespace volccd::detail {

/// Roots in [0,1] of q0 s^2 + 2 q1 s t + q2 t^2, s = 1 - t, ascending: their number, 0 to 2. Each has small relative
/// error in t and in 1 - t, but for the loss that a near-double root implies. None for the zero polynomial.
int quadratic_roots(double q0, double q1, double q2, std::array<double, 2>& roots);

/// [0,1] cut at the critical points: f is monotone on each [cut[k], cut[k+1]], up to less than its rounding bound.
struct MonotonePieces {
  std::array<double, 4> cut;
  int count;
};
MonotonePieces monotone_pieces(const CoplanarityCubic& f);

/// The root of f in [a,b], given f(a) f(b) < 0 and f monotone: Newton's method kept inside the bracket by bisection,
/// until the step vanishes in double precision.
double bracketed_root(const CoplanarityCubic& f, double a, double b);

/// The part of a monotone piece [a,b] where the sign of f is not proven, {lo, hi}, rounded outwards. Pre: there is one.
std::array<double, 2> zero_stretch(const CoplanarityCubic& f, double a, double b);

}  // namespace volccd::detail
