// Rounding bounds of the CSAT kernels in single precision. Derivation: docs/numerics.md, "Single precision".
#pragma once

#include <algorithm>
#include <limits>

namespace volccd::detail {

/// Half the distance from 1 to the next float.
inline constexpr float kFloatRoundoff = 0x1p-24f;
/// A lane whose sum of magnitudes exceeds this value is regarded as not separated.
inline constexpr float kFloatGreatestMagnitude = 0x1p100f;

/// Gap along an axis L as in query/rounding.hpp, for differences that are computed in doubles and rounded once to
/// floats:
///     T = float_gap_error_factor(n) * S + kFloatGapUnderflow [+ separation term],   S = |Lx| Dx + |Ly| Dy + |Lz| Dz
/// where Dk = max(kFloatLeastExtent, max |xk - rk| as a float), and n levels of de Casteljau's algorithm are applied to
/// the floats.
constexpr float float_gap_error_factor(int levels) { return static_cast<float>(10 + 6 * levels) * kFloatRoundoff; }
inline constexpr float kFloatGapUnderflow = 0x1p-145f;
inline constexpr float kFloatLeastExtent = 0x1p-126f;

/// Compensates for rounding when a length is multiplied by a separation and added to a sum.
inline constexpr float kFloatLengthSlack = 1 + 16 * kFloatRoundoff;
/// For sums of squares below this value, the sum of absolute values replaces the length.
inline constexpr float kFloatLeastSquare = 0x1p-100f;

/// The separation as a float: at least `separation`, except for one relative rounding; infinite beyond the range of the
/// kernels.
inline float float_separation(double separation) {
  if (separation == 0) return 0;
  if (!(separation < kFloatGreatestMagnitude)) return std::numeric_limits<float>::infinity();
  return std::max(static_cast<float>(separation), std::numeric_limits<float>::min());
}

}  // namespace volccd::detail
