// Elementary functions with the same bits on every machine. The C library chooses among code paths by processor, and in
// an explicit simulation a difference in the last bit changes the result visibly. Errors are below 1e-15, relative or
// absolute, whichever is larger.
#pragma once

#include <cmath>

namespace volccd::simulation::detail {

/// Half of log(x), x > 0 and finite.
inline double half_log(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < 0.7071067811865476) {
    m *= 2;
    --exponent;
  }
  const double s = (m - 1) / (m + 1), z = s * s;
  double sum = 1.0 / 23;
  for (int k = 21; k >= 1; k -= 2) sum = sum * z + 1.0 / k;
  return s * sum + exponent * 0.34657359027997264;
}

inline double portable_log(double x) { return 2 * half_log(x); }

/// e^x, with x clamped to [-700, 700].
inline double portable_exp(double x) {
  x = std::fmin(std::fmax(x, -700.0), 700.0);
  const double n = std::nearbyint(x * 1.4426950408889634);
  const double r = (x - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;
  double sum = 1;
  for (int k = 14; k >= 1; --k) sum = sum * (r / k) + 1;
  return std::ldexp(sum, static_cast<int>(n));
}

/// Coefficients of the rational approximation of atan in [-0.66, 0.66] (Cephes, Moshier 1995).
inline constexpr double kAtanP[] = {-8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1,
                                    -1.228866684490136173410e2, -6.485021904942025371773e1};
inline constexpr double kAtanQ[] = {1,
                                    2.485846490142306297962e1,
                                    1.650270098316988542046e2,
                                    4.328810604912902668951e2,
                                    4.853903996359136964868e2,
                                    1.945506571482613964425e2};

/// Angle of (x, y) in [-pi, pi]; 0 at the origin.
inline double portable_atan2(double y, double x) {
  const double ax = std::fabs(x), ay = std::fabs(y), hi = ax > ay ? ax : ay, lo = ax > ay ? ay : ax;
  if (hi == 0) return 0;
  const bool steep = lo > 0.66 * hi;
  const double t = steep ? (lo - hi) / (lo + hi) : lo / hi, z = t * t;
  double p = kAtanP[0], q = kAtanQ[0];
  for (int k = 1; k < 5; ++k) p = p * z + kAtanP[k];
  for (int k = 1; k < 6; ++k) q = q * z + kAtanQ[k];
  double angle = t * (z * (p / q)) + t;
  if (steep) angle = 0.7853981633974483 + angle;
  if (ay > ax) angle = 1.5707963267948966 - angle;
  if (x < 0) angle = 3.141592653589793 - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace volccd::simulation::detail
