// Tests of every feature of one list against every feature of another, appended at once.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Appends the VF tests vertices x triangles.
inline void append_vf(std::span<const Index> vertices, std::span<const Index> triangles,
                      std::vector<FeaturePair>& tests) {
  const std::size_t begin = tests.size();
  tests.resize(begin + vertices.size() * triangles.size());
  FeaturePair* to = tests.data() + begin;
  for (const Index v : vertices)
    for (const Index f : triangles) *to++ = {v, f};
}

/// Appends the EE tests edges_a x edges_b; no edge is in both lists.
inline void append_ee(std::span<const Index> edges_a, std::span<const Index> edges_b, std::vector<FeaturePair>& tests) {
  const std::size_t begin = tests.size();
  tests.resize(begin + edges_a.size() * edges_b.size());
  FeaturePair* to = tests.data() + begin;
  for (const Index e : edges_a)
    for (const Index g : edges_b) *to++ = {std::min(e, g), std::max(e, g)};
}

}  // namespace volccd::detail
