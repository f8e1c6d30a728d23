// Cost of a CSAT sign test and of an elementary test: floating-point operations and nanoseconds (Section 7.1).
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/query_source.hpp>

namespace volccd {

struct OperationConfig {
  std::size_t tests = 2048;  ///< greatest number of each kind, evenly spread over the queries; fits into the cache
  int repetitions = 15;      ///< timed passes of each operation, interleaved; the median is reported
  double tolerance = 1e-10;  ///< of the elementary test (`provot.tolerance`)
};

/// Operations of the reference implementation of 2011 (culling/csat_reference.hpp, narrowphase/provot_test.hpp) on the
/// given tests, as mean and maximum over these, counted with CountedDouble; and nanoseconds of the same code in plain
/// doubles.
/// Queries whose motion has three control points are left out. Returns
///
///   {"tolerance": of the elementary test,
///    "rows": [{"operation", "kind": "vf" or "ee", "tests",
///              "positive": share of the tests that the operation finds apart (CSAT) or touching (elementary test),
///              "additions": mean, with subtractions, "multiplications", "divisions", "comparisons", "square_roots",
///              "absolute_values",
///              "most": {the same, each the maximum over the tests}, "ns": of a test,
///              "paper": {"additions", "multiplications", "divisions"}, or null where the paper has no number}]}
///
/// Operations, for each kind that has tests:
///   csat             Corollary 1 or 3 along a given axis: signs of 4 or 5 dot products, up to the first that decides
///   csat-with-axis   the same, and the axis from the features at t = 0
///   csat-element     Corollary 2 or 4 along a given axis: the vertex, or first edge, against an element that has the
///                    other feature
///   elementary-test  roots of the cubic and inside test
///   elementary-test-left   the same on those of the tests alone that `csat` does not find apart, if there are any
/// Runs on one thread. Times include loading positions; counts do not.
nlohmann::json operation_counts(const std::vector<KnownQueries>& queries, const OperationConfig& config = {});

}  // namespace volccd
