// All elementary tests of a mesh.
#pragma once

#include <vector>

#include <volccd/mesh/features.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::test {

/// All tests of a kind, VF: each vertex with each triangle.
inline std::vector<FeaturePair> all_tests(const Features& features, FeatureKind kind) {
  std::vector<FeaturePair> tests;
  const bool vf = kind == FeatureKind::vf;
  for (Index a = 0; a < (vf ? features.vertex_slots() : features.edge_slots()); ++a)
    for (Index b = vf ? 0 : a + 1; b < (vf ? features.triangle_slots() : features.edge_slots()); ++b)
      if (is_test(features, kind, {a, b})) tests.push_back({a, b});
  return tests;
}

}  // namespace volccd::test
