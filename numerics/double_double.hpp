// Numbers of about 106 bits as unevaluated sums of two doubles (Dekker 1971; Knuth). Products use splitting instead of
// fused multiply-add, so that results are the same on every processor.
#pragma once

namespace volccd::detail {

struct DoubleDouble {
  double high, low;
};

/// Exact if there is no overflow.
inline DoubleDouble exact_sum(double a, double b) {
  const double s = a + b, v = s - a;
  return {s, (a - (s - v)) + (b - v)};
}
inline DoubleDouble exact_difference(double a, double b) { return exact_sum(a, -b); }

/// Exact if the product is zero or its magnitude is between 2^-960 and 2^960.
inline DoubleDouble exact_product(double a, double b) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const double p = a * b, ta = kSplit * a, tb = kSplit * b;
  const double ah = ta - (ta - a), al = a - ah, bh = tb - (tb - b), bl = b - bh;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

/// The error is less than 2^-104 (|a| + |b|).
inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble s = exact_sum(a.high, b.high);
  const double low = s.low + (a.low + b.low), high = s.high + low;
  return {high, low - (high - s.high)};
}
inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + DoubleDouble{-b.high, -b.low}; }

/// The error is less than 2^-102 |a b|.
inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble p = exact_product(a.high, b.high);
  const double low = p.low + (a.high * b.low + a.low * b.high), high = p.high + low;
  return {high, low - (high - p.high)};
}

}  // namespace volccd::detail
