// Appends the tests of all features of one list against all features of another list.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Appends the VF tests of all pairs in vertices x triangles.
inline void append_vf(std::span<const Index> vertices, std::span<const Index> triangles,
                      std::vector<FeaturePair>& tests) {
  const std::size_t begin = tests.size();
  tests.resize(begin + vertices.size() * triangles.size());
  FeaturePair* to = tests.data() + begin;
  for (const Index v : vertices)
    for (const Index f : triangles) *to++ = {v, f};
}

/// Appends the EE tests of all pairs in edges_a x edges_b. No edge may be in both lists.
inline void append_ee(std::span<const Index> edges_a, std::span<const Index> edges_b, std::vector<FeaturePair>& tests) {
  const std::size_t begin = tests.size();
  tests.resize(begin + edges_a.size() * edges_b.size());
  FeaturePair* to = tests.data() + begin;
  for (const Index e : edges_a)
    for (const Index g : edges_b) *to++ = {std::min(e, g), std::max(e, g)};
}

}  // namespace volccd::detail
