// Rounding bounds of the `inclusion` narrow phase in addition to those of numerics/rounding.hpp. Derivations:
// docs/numerics.md, "Intervals of the step".
#pragma once

#include <volccd/numerics/rounding.hpp>

namespace volccd::detail {

/// Bernstein coefficients of L . (e_i x e_j), each times its binomial, over an interval of the step that was computed
/// with n levels of de Casteljau's algorithm. The error is less than binomial * (factor * permanent of |L| and the
/// extents) + kDeterminantUnderflow (1 + |L|_1); the error of the sum of three of them is less than the sum of their
/// bounds.
constexpr double quadric_error_factor(int levels) { return (12 + 8 * levels) * kUnitRoundoff; }

/// The rounding error of a polynomial's value, computed by Horner's scheme from Bernstein coefficients with binomials,
/// or of a coefficient over an interval, computed by de Casteljau's algorithm, is less than this factor times the
/// greatest coefficient.
constexpr double value_error_factor(int degree) { return 8 * degree * kUnitRoundoff; }

/// Factor for the contribution of the errors of the coefficients to a value; without rounding, their weights sum to 1.
inline constexpr double kCubicErrorSlack = 2;

/// Bernstein coefficients of degree 4 of the gap along an axis that turns (a curve of second degree), each times its
/// binomial, over an interval of the step that was computed with n levels of de Casteljau's algorithm. The error is
/// less than binomial * (factor * S + kGapUnderflow), S from the extents and the greatest magnitudes of the curve's
/// points.
constexpr double curve_error_factor(int levels) { return (16 + 6 * levels) * kUnitRoundoff; }
/// A coefficient of (|n|^2 + 1) / 2, which is at least the length |n| of the curve n, multiplied by a separation: its
/// error is less than binomial / 2 * factor * (1 + |n|^2), with the greatest magnitudes of the curve's points.
inline constexpr double kCurveLengthError = 16 * kUnitRoundoff;

/// Half of the length of the interval around a root in which the features are examined first.
inline constexpr double kRootMargin = 0x1p-16;

}  // namespace volccd::detail
