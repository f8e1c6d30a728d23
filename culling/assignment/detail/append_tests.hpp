// What assignments do with lists of features: visit those that a mask does not exclude, and append tests.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Calls visit(feature) for each feature whose bit in `mask` is not set. Features beyond the number of bits are always
/// visited (FeatureMask).
template <class Mask, class Visit>
void for_each_unmasked(std::span<const Index> features, Mask mask, Visit&& visit) {
  constexpr std::size_t bits = 8 * sizeof(Mask);
  for (std::size_t i = 0; i < features.size(); ++i)
    if (i >= bits || (mask >> i & 1) == 0) visit(features[i]);
}

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
