// Cost of k-DOPs and of oriented bounding boxes over a motion: operations and nanoseconds (Section 7.2).
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/paper2011/operations.hpp>

namespace volccd {

/// Rows in the form of operation_counts(), on elements of the step and on pairs of elements without a common vertex
/// whose swept boxes overlap, both evenly spread, at most `config.tests` of each:
///   kdop-update, obb-update   kind "element": the bounds of one element over the motion, from the positions of its
///                             vertices at both ends (paper2011/moving_obb.hpp); "positive" is null
///   kdop-test, obb-test       kind "element-pair": whether two such bounds are apart
/// "paper" of obb-test has "comparisons" and "absolute_values" too, that of obb-update {"slower": [15, 25]}: the times
/// that it is slower than with k-DOPs. There are no rows for an empty selection. The code is scalar, in doubles, and
/// has the same guarantee for both; no tree is built. Throws ConfigError if the motion has more than two control
/// points.
std::vector<nlohmann::json> bound_operation_counts(const Step& step, const OperationConfig& config = {});

}  // namespace volccd
