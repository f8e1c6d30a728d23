// Rounding bounds of the CSAT kernels that work in single precision. Derivation: docs/numerics.md, "Single precision".
#pragma once

#include <algorithm>
#include <limits>

namespace volccd::detail {

/// Half the distance from 1 to the next float.
inline constexpr float kFloatRoundoff = 0x1p-24f;
/// Kernels trust no sum of magnitudes that exceeds this: its lane counts as not separated.
inline constexpr float kFloatGreatestMagnitude = 0x1p100f;

/// Gap along an axis L as in query/rounding.hpp, on differences that were computed in doubles and rounded to floats
/// once:
///     T = float_gap_error_factor(n) * S + kFloatGapUnderflow [+ separation term],   S = |Lx| Dx + |Ly| Dy + |Lz| Dz
/// where Dk = max(kFloatLeastExtent, max |xk - rk| as a float), and n levels of de Casteljau's scheme were applied to
/// the floats.
constexpr float float_gap_error_factor(int levels) { return static_cast<float>(10 + 6 * levels) * kFloatRoundoff; }
inline constexpr float kFloatGapUnderflow = 0x1p-145f;
inline constexpr float kFloatLeastExtent = 0x1p-126f;

/// Makes up for the rounding of a length times a separation, in a sum.
inline constexpr float kFloatLengthSlack = 1 + 16 * kFloatRoundoff;
/// Of sums of squares below this the sum of absolute values stands in for the length.
inline constexpr float kFloatLeastSquare = 0x1p-100f;

/// The separation as a float: at least `separation` up to one relative rounding; infinite where floats end.
inline float float_separation(double separation) {
  if (separation == 0) return 0;
  if (!(separation < kFloatGreatestMagnitude)) return std::numeric_limits<float>::infinity();
  return std::max(static_cast<float>(separation), std::numeric_limits<float>::min());
}

}  // namespace volccd::detail
