// Elementary functions with the same results on every processor and with every C library, for positions of scenes.
// Those of a C library differ in the last bit, also between processors with and without fused multiply-add.
#pragma once

namespace volccd {

/// Rounded to nearest from 100 bits: the nearest double unless the value is within 2^-46 of the distance between two
/// doubles from their midpoint. Pre: |x| <= 10^6; for portable_exp, |x| <= 700.
double portable_sin(double x);
double portable_cos(double x);
double portable_exp(double x);
/// The square root of x^2 + y^2, rounded in the same way. Pre: x and y are finite.
double portable_hypot(double x, double y);

}  // namespace volccd
