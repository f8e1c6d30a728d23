// Rounding bounds that culling and elementary tests share. Derivations: docs/numerics.md. All hold for IEEE doubles,
// round to nearest, gradual underflow (no flush to zero), no contraction into fused multiply-add.
//
// Pattern: a kernel computes a quantity q and, from magnitudes alone, a threshold T. `q > T` is true only if the exact
// quantity on the given doubles is positive (or beyond the separation). Overflow makes T infinite or NaN, and the
// comparison false.
#pragma once

#include <cmath>

namespace volccd {

/// Half the distance from 1 to the next double: fl(x op y) = (x op y)(1 + e), |e| <= kUnitRoundoff, but for underflow.
inline constexpr double kUnitRoundoff = 0x1p-53;

/// Kernels trust nothing whose magnitudes (extents, S, permanents, sums of coordinates below) exceed this: intermediate
/// values could overflow, and the minimum or maximum of a set with a NaN in it is not reliable.
inline constexpr double kGreatestMagnitude = 0x1p1000;

/// Gap along an axis L: q = min over one point set - max over another of fl(L . fl(x - r)), for any reference point r.
///     T = gap_error_factor(n) * S + kGapUnderflow [+ separation_gap(d, |L|)],   S = |Lx| Dx + |Ly| Dy + |Lz| Dz
/// where Dk = max(kLeastExtent, max |fl(xk - rk)|) over all control points, and n levels of de Casteljau's scheme
/// (weights fl(1 - s) and s) were applied to the differences to restrict them to [0, s]. Section "Dot products along an
/// axis".
constexpr double gap_error_factor(int levels) { return (10 + 6 * levels) * kUnitRoundoff; }
inline constexpr double kGapUnderflow = 0x1p-1070;
inline constexpr double kLeastExtent = 0x1p-1000;

/// Make up for the rounding of a length (of a product of two lengths), times a separation, in a sum. Section "Lengths".
inline constexpr double kLengthSlack = 1 + 16 * kUnitRoundoff;
inline constexpr double kAreaSlack = 1 + 32 * kUnitRoundoff;
/// Sums of squares below this may have lost digits to underflow: take the sum of absolute values for the length
/// instead.
inline constexpr double kLeastSquare = 0x1p-900;

/// At least separation * |L|, also after being added to a few other terms; 0 for separation 0.
inline double separation_gap(double separation, double lx, double ly, double lz) {
  if (separation == 0) return 0;
  const double square = lx * lx + ly * ly + lz * lz;
  const double length = square > kLeastSquare ? std::sqrt(square) : std::abs(lx) + std::abs(ly) + std::abs(lz);
  return separation * (length * kLengthSlack);
}

/// Bernstein coefficients, times binomial(degree, k), of det(e1, e2, e3)(t), ei = differences of points of `points`
/// control points each (2: degree 3; 3: degree 6). The error of coefficient k is below
///     binomial(degree, k) * (determinant_error_factor(points, n) * permanent(E) + separation term)
///       + kDeterminantUnderflow * (1 + E1x + E1y + E1z)
/// where Eik = max(kLeastExtent, |eik|) over all control points, and n as above. Section "Coplanarity".
constexpr double determinant_error_factor(int points, int levels) {
  return (4 * points + 6 + 9 * levels) * kUnitRoundoff;
}
inline constexpr double kDeterminantUnderflow = 0x1p-1060;
/// Sum of three coordinates of magnitude at most Mx, My, Mz, two such sums subtracted (or lerped coordinates, n
/// levels): error below sum_error_factor(n) * (Mx + My + Mz). Section "Bounds along fixed axes".
constexpr double sum_error_factor(int levels) { return (8 + 6 * levels) * kUnitRoundoff; }

}  // namespace volccd
