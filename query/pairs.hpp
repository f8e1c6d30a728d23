// Pairs of elements, and pairs of features: what the stages of a pipeline hand on.
#pragma once

#include <array>
#include <compare>
#include <cstdint>

#include <volccd/mesh/features.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd {

/// Two element slots. From a broad phase: a < b, or a == b for the pair of an element with itself.
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

/// Vertex slots of a test. VF: {vertex, triangle ascending}. EE: {edge a ascending, edge b ascending}, the edges swapped if
/// need be so that the first is lexicographically smaller: kernels see each test in one canonical order, whichever
/// stage it came through, and so their results agree bit for bit.
std::array<Index, 4> test_vertices(const Features& features, FeatureKind kind, FeaturePair pair);

/// Whether the two features have no vertex in common (only then is there a test).
bool is_test(const Features& features, FeatureKind kind, FeaturePair pair);

}  // namespace volccd
