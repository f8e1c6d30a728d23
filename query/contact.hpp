// The result type of a query: one contact of two features.
#pragma once

#include <array>

#include <volccd/numerics/types.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// A vertex-face or edge-edge contact. Vertices are slots; slots are in the order of the stable ids (Mesh).
struct Contact {
  FeatureKind kind;
  /// VF: {vertex, triangle ascending}. EE: {edge 1 ascending, edge 2 ascending}, edge 1 < edge 2 lexicographically.
  std::array<Index, 4> vertices;
  double toi;  ///< first time of contact, in [0,1] of the step
  /// Unit normal at toi, directed from the second feature (triangle, edge 2) towards the position of the first feature
  /// before the contact; zero if the geometry does not determine it.
  Vec3 normal;
  /// Weights of `vertices`. VF: {1, w0, w1, w2}, where the weights of the triangle sum to 1. EE: {1-s, s, 1-u, u}.
  std::array<double, 4> weights;
  Vec3 point;  ///< point of contact on the second feature, at toi
  /// Whether the features touch, or are closer than the separation, at t = 0; then toi is 0. (The converse does not
  /// hold: a tolerance in time may round toi to 0 for a later contact.)
  bool at_start = false;
  // A pipeline sets the next two; a narrow phase leaves them as they are.
  /// The slots of the two features, in the order of `vertices`: vertex and triangle, or edge 1 and edge 2.
  FeaturePair features = {kNone, kNone};
  /// Of each feature, the slot of the incident element of smallest id.
  std::array<Index, 2> elements = {kNone, kNone};
  double gap = 0;  ///< distance of the features at toi, in the unit of the coordinates, up to rounding

  /// Without slots of features and elements, which depend on the edits that made the topology.
  friend bool operator==(const Contact& x, const Contact& y) {
    return x.kind == y.kind && x.vertices == y.vertices && x.toi == y.toi && x.normal == y.normal &&
           x.weights == y.weights && x.point == y.point && x.at_start == y.at_start && x.gap == y.gap;
  }
};

/// The features of a contact at the end of the step (t = 1), which may have passed through each other.
struct ContactEnd {
  double gap;  ///< distance of the features, in the unit of the coordinates, up to rounding; not signed
  std::array<double, 4> weights;  ///< of the vertices, as in Contact, for the closest points
  Vec3 first, second;             ///< closest points of the first and of the second feature

  friend bool operator==(const ContactEnd&, const ContactEnd&) = default;
};

/// Canonical order: by kind, then by vertices.
inline bool canonical_less(const Contact& x, const Contact& y) {
  return x.kind != y.kind ? x.kind < y.kind : x.vertices < y.vertices;
}

}  // namespace volccd
