// Bounds on rounding errors for culling and elementary tests. Derivations: docs/numerics.md. All of them assume IEEE
// doubles, rounding to nearest, gradual underflow (no flush to zero), and no contraction to fused multiply-add.
//
// Usage: a kernel computes a quantity q and, from magnitudes alone, a threshold T. If `q > T` is true, the exact
// quantity for the given doubles is positive (or greater than the separation). Overflow makes T infinite or NaN, and
// then the comparison is false.
#pragma once

#include <cmath>

namespace volccd {

/// Half the distance from 1 to the next double. Without underflow, fl(x op y) = (x op y)(1 + e) with |e| <=
/// kUnitRoundoff.
inline constexpr double kUnitRoundoff = 0x1p-53;

/// Kernels treat a test as undecided if a magnitude (the extents, S, permanents and sums of coordinates below) exceeds
/// this value: intermediate values might overflow, and the minimum or maximum of a set that contains NaN is not
/// reliable.
inline constexpr double kGreatestMagnitude = 0x1p1000;

/// Gap along an axis L: q = min over one point set - max over another of fl(L . fl(x - r)), for any reference point r.
///     T = gap_error_factor(n) * S + kGapUnderflow [+ separation_gap(d, |L|)],   S = |Lx| Dx + |Ly| Dy + |Lz| Dz
/// where Dk = max(kMinExtent, max |fl(xk - rk)|) over all control points, and n is the number of levels of de
/// Casteljau's algorithm (weights fl(1 - s) and s) that were applied to the differences to restrict them to [0, s].
/// Derivation: section "Dot products along an axis".
constexpr double gap_error_factor(int levels) { return (10 + 6 * levels) * kUnitRoundoff; }
inline constexpr double kGapUnderflow = 0x1p-1070;
inline constexpr double kMinExtent = 0x1p-1000;

/// Factors that compensate for rounding when a length, or a product of two lengths, is multiplied by a separation and
/// added to a sum. Derivation: section "Lengths".
inline constexpr double kLengthSlack = 1 + 16 * kUnitRoundoff;
inline constexpr double kAreaSlack = 1 + 32 * kUnitRoundoff;
/// A sum of squares below this value may have lost digits by underflow; use the sum of absolute values instead of the
/// length.
inline constexpr double kMinSquare = 0x1p-900;

/// An upper bound on separation * |L| that remains valid after a few other terms are added; 0 for separation 0.
inline double separation_gap(double separation, double lx, double ly, double lz) {
  if (separation == 0) return 0;
  const double square = lx * lx + ly * ly + lz * lz;
  const double length = square > kMinSquare ? std::sqrt(square) : std::abs(lx) + std::abs(ly) + std::abs(lz);
  return separation * (length * kLengthSlack);
}

/// Bernstein coefficients, multiplied by binomial(degree, k), of det(e1, e2, e3)(t), where the ei are differences of
/// points with `points` control points each (2: degree 3; 3: degree 6). The error of coefficient k is less than
///     binomial(degree, k) * (determinant_error_factor(points, n) * permanent(E) + separation term)
///       + kDeterminantUnderflow * (1 + E1x + E1y + E1z)
/// where Eik = max(kMinExtent, |eik|) over all control points, and n is as above. Derivation: section "Coplanarity".
constexpr double determinant_error_factor(int points, int levels) {
  return (4 * points + 6 + 9 * levels) * kUnitRoundoff;
}
/// A normal number, although 2^-1060 would do: products with a denormal one take over a hundred cycles.
inline constexpr double kDeterminantUnderflow = 0x1p-1020;
/// Difference of two sums of three coordinates with magnitudes of at most Mx, My, Mz, interpolated by n levels of de
/// Casteljau's algorithm: the error is less than sum_error_factor(n) * (Mx + My + Mz). Derivation: section "Bounds
/// along fixed axes".
constexpr double sum_error_factor(int levels) { return (8 + 6 * levels) * kUnitRoundoff; }

}  // namespace volccd
