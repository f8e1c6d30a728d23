// What a query returns: one contact of two features.
#pragma once

#include <array>

#include <volccd/mesh/types.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// A vertex-face or edge-edge contact. Vertices are slots; slots ascend with the stable ids (Mesh), so that slot order
/// is id order.
struct Contact {
  FeatureKind kind;
  /// VF: {vertex, triangle ascending}. EE: {edge 1 ascending, edge 2 ascending}, edge 1 < edge 2 lexicographically.
  std::array<Index, 4> vertices;
  double toi;  ///< first time of contact, in [0,1] of the step
  /// Unit normal at toi, from the second feature (triangle, edge 2) towards the first as it was before the contact;
  /// zero where the geometry gives none.
  Vec3 normal;
  /// Weights of `vertices`. VF: {1, w0, w1, w2}, the triangle's sum to 1. EE: {1-s, s, 1-u, u}.
  std::array<double, 4> weights;
  Vec3 point;  ///< on the second feature, at toi
  /// They touch, or are closer than the separation, at t = 0 already; toi is 0 then. (A contact that a tolerance in
  /// time moved to 0 has toi 0 without.)
  bool at_start = false;

  friend bool operator==(const Contact&, const Contact&) = default;
};

/// Canonical order: kind, then vertices.
inline bool canonical_less(const Contact& x, const Contact& y) {
  return x.kind != y.kind ? x.kind < y.kind : x.vertices < y.vertices;
}

}  // namespace volccd
