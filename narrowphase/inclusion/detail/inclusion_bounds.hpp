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

/// The distance of closest_points() is that of two points of the features up to an error of this factor times the sum
/// of the extents, for up to three control points: 12 u per axis, for both features.
inline constexpr double kDistanceError = 64 * kUnitRoundoff;

/// Half of the length of the interval around a root in which the features are examined first.
inline constexpr double kRootMargin = 0x1p-16;

}  // namespace volccd::detail
