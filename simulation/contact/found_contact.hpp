// A contact in terms of the simulated mesh: its features, its direction, and whether it is resisted.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/query/contact.hpp>

namespace volccd::simulation {

enum class ContactClass : std::uint8_t {
  inter,    ///< between features of different objects
  intra,    ///< within one object; not all pairs of elements of the two features are adjacent
  adjacent  ///< all pairs of elements of the two features are adjacent: the O-Set of Section 5.1
};

enum class ContactVerdict : std::uint8_t {
  resist,
  leaving,  ///< one feature leaves the inside of the other body, or an inverted element turns back
  ignore    ///< the direction is unknown, another pair is nearer, or options exclude it
};

/// A contact between features. Their relative displacement along the normal is normal . sum(weights[i] * displacement
/// of vertices[i]), positive if they move apart.
struct FoundContact {
  FeatureKind kind;
  std::array<Index, 4> features;  ///< Contact::vertices: vertices of the collision mesh
  FeaturePair slots;              ///< Contact::features
  std::array<Index, 4> vertices;  ///< of the simulated mesh: for a shell's prism, the vertices of the shell
  std::array<double, 4> weights;  ///< of the first feature; those of the second are negative
  Vec3 normal;                    ///< to the side of the second feature on which the first should be
  double toi;
  double gap0, gap1;  ///< distance of the contact points along the normal, at start and end
  bool at_start;
  bool solid;  ///< no shell is involved
  ContactClass contact_class;
  ContactVerdict verdict;
  std::int32_t object_a, object_b;
};

/// Same order as canonical_less.
inline bool same_features(const FoundContact& x, const FoundContact& y) {
  return x.kind == y.kind && x.features == y.features;
}
inline bool features_less(const FoundContact& x, const FoundContact& y) {
  return x.kind != y.kind ? x.kind < y.kind : x.features < y.features;
}

}  // namespace volccd::simulation
