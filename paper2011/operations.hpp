// Cost of a CSAT sign test, of an elementary test (Section 7.1) and of coplanarity-based culling (Section 7.2):
// floating-point operations and nanoseconds.
#pragma once

#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/query/step.hpp>

namespace volccd {

/// Tests of one kind on one step.
struct TestList {
  FeatureKind kind;
  Step step;
  std::span<const FeaturePair> pairs;
};

struct OperationConfig {
  std::size_t tests = 2048;  ///< greatest number of each kind, evenly spread over the queries; fits into the cache
  int repetitions = 15;      ///< timed passes of each operation, interleaved; the median is reported
  double tolerance = 1e-10;  ///< of the elementary test (`provot.tolerance`)
};

/// Operations of the reference implementation of 2011 (paper2011/csat_reference.hpp, paper2011/provot_test.hpp,
/// coplanarity_reference.hpp) on the tests of the lists, as mean and maximum over these, counted with CountedDouble;
/// and nanoseconds of the same code in plain doubles. Lists whose motion has three control points are left out. Returns
///
///   {"tolerance": of the elementary test,
///    "rows": [{"operation", "kind": "vf" or "ee", "tests",
///              "positive": share of the tests that the operation finds apart (CSAT, coplanarity) or touching
///              (elementary
///                          test),
///              "additions": mean, with subtractions, "multiplications", "divisions", "comparisons", "square_roots",
///              "absolute_values",
///              "max": {the same, each the maximum over the tests}, "ns": of a test,
///              "paper": {"additions", "multiplications", "divisions"}, {"over_csat": cost over that of CSAT}, or null
///                       where the paper has no number}]}
///
/// Operations, for each kind that has tests:
///   csat             Corollary 1 or 3 along a given axis: signs of 4 or 5 dot products, up to the first that decides
///   csat-with-axis   the same, and the axis from the features at t = 0
///   coplanarity      non-penetration filter: signs of the four Bernstein coefficients of the coplanarity cubic, up to
///                    the first that decides
///   csat-element     Corollary 2 or 4 along a given axis: the vertex, or first edge, against an element that has the
///                    other feature
///   csat-element-with-axis   the same, and the axis from the features at t = 0
///   coplanarity-element      coplanarity of the vertex, or first edge, and each triangle, or edge, of that element
///                    (for a tetrahedron 4 triangles, or 6 edges), all of which are computed; apart if all are
///   elementary-test  roots of the cubic and inside test
///   elementary-test-left   the same on those of the tests alone that `csat` does not find apart, if there are any
/// Runs on one thread. Times include loading positions; counts do not.
nlohmann::json operation_counts(std::span<const TestList> lists, const OperationConfig& config = {});

}  // namespace volccd
