// Pairs of elements and pairs of features, which the stages of a pipeline exchange.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>

#include <volccd/mesh/features.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// Two element slots. A broad phase emits pairs with a < b, or a == b for the self pair of an element.
struct ElementPair {
  Index a, b;
  auto operator<=>(const ElementPair&) const = default;
};

enum class FeatureKind : std::uint8_t {
  vf,  ///< a vertex against a triangle
  ee   ///< an edge against an edge
};

/// VF: a = vertex slot, b = triangle slot. EE: a < b, edge slots.
struct FeaturePair {
  Index a, b;
  auto operator<=>(const FeaturePair&) const = default;
};

/// Vertex slots of a test. VF: {vertex, triangle ascending}. EE: {edge ascending, edge ascending}, the
/// lexicographically smaller edge first. Every kernel receives a test in this canonical order, whichever stage produced
/// it, so that results are the same bit for bit.
inline std::array<Index, 4> test_vertices(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return {pair.a, f[0], f[1], f[2]};
  }
  // Compared as one number, without a branch: the order is hard to predict.
  const auto number = [](const std::array<Index, 2>& e) { return std::uint64_t{e[0]} << 32 | e[1]; };
  const std::uint64_t a = number(features.edge(pair.a)), b = number(features.edge(pair.b));
  const std::uint64_t first = std::min(a, b), second = std::max(a, b);
  return {static_cast<Index>(first >> 32), static_cast<Index>(first), static_cast<Index>(second >> 32),
          static_cast<Index>(second)};
}

/// Whether the two features have no vertex in common; pairs with a common vertex are not tested.
inline bool is_test(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return pair.a != f[0] && pair.a != f[1] && pair.a != f[2];
  }
  const std::array<Index, 2>&a = features.edge(pair.a), &b = features.edge(pair.b);
  return a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1];
}

}  // namespace volccd
