// The first time at which two features come within a distance, in exact arithmetic (docs/narrowphase_exact.md).
#pragma once

#include <volccd/narrowphase/exact/exact_predicates.hpp>

namespace volccd::detail {

/// The answer of exact_first_touch() for a separation > 0.
///
/// Proof. If the features are not within d at 0 and T > 0 is the first time at which they are, their distance is d at
/// T. Among the pairs of parts (points, edges, the triangle) whose closest points are in the relative insides of both,
/// take one of least dimension. The parts have a length, an area or no common direction at T, because otherwise the
/// closest points would be on parts of lower dimension. So just before T, too, the closest points of the lines or
/// planes of these parts are inside the parts. If the polynomial of the pair were zero, their distance would be d then,
/// and the features within d before T. Hence T is a root of the polynomial of this pair, which is not zero. Conversely,
/// at every root at which the closest points are in the parts, the features are within d.
ExactAnswer first_approach(const TestMotion& motion, double separation, double t_max);

}  // namespace volccd::detail
