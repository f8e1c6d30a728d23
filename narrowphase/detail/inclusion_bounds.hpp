// Rounding bounds of the `inclusion` narrow phase beyond those of query/rounding.hpp. Derivations: docs/numerics.md,
// "Parts of the step".
#pragma once

#include <volccd/query/rounding.hpp>

namespace volccd::detail {

/// Bernstein coefficients of L . (e_i x e_j), each times its binomial, over a part of the step that took n levels of de
/// Casteljau's scheme: the error is below binomial * (factor * permanent of |L| and the extents) +
/// kDeterminantUnderflow (1 + |L|_1); of the sum of three of them, below the sum of the bounds.
constexpr double quadric_error_factor(int levels) { return (12 + 8 * levels) * kUnitRoundoff; }

/// A polynomial's value from Bernstein coefficients with binomials, by Horner's scheme, or a coefficient of a part of
/// it, by de Casteljau's: rounding is below this times the greatest coefficient.
constexpr double value_error_factor(int degree) { return 8 * degree * kUnitRoundoff; }

/// For the error of the coefficients themselves in a value: their weights add up to 1, but for rounding.
inline constexpr double kCubicErrorSlack = 2;

/// A distance from closest_points() is that of two points of the features, to within this times the sum of the extents,
/// up to three control points: 12 u an axis, for both features.
inline constexpr double kDistanceError = 64 * kUnitRoundoff;

/// Half the length of the piece around a root in which features are looked at first.
inline constexpr double kRootMargin = 0x1p-16;

}  // namespace volccd::detail
