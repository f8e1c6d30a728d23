// A contact in terms of the simulated mesh: between what, in which direction, and whether it is resisted.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/query/contact.hpp>

namespace volccd::simulation {

enum class ContactClass : std::uint8_t {
  inter,    ///< of different objects
  intra,    ///< of one object, no two elements at them adjacent but some that are not
  adjacent  ///< all elements at the one are adjacent to all at the other: in the O-Set of Section 5.1
};

enum class ContactVerdict : std::uint8_t {
  resist,
  leaving,  ///< one comes out of the inside of the other, or an inverted element turns back
  ignore    ///< no direction, or not asked for
};

/// A contact between features. Their relative displacement along the normal is normal . sum(weights[i] * displacement
/// of vertices[i]), positive where they part.
struct FoundContact {
  FeatureKind kind;
  std::array<Index, 4> features;  ///< Contact::vertices: of the collision mesh, which name the pair
  std::array<Index, 4> vertices;  ///< of the simulated mesh: for a shell's prism, the vertices of the shell
  std::array<double, 4> weights;  ///< those of the first feature, less those of the second
  Vec3 normal;                    ///< from the second feature to the first as they should lie
  double toi;
  double gap0, gap1;  ///< along the normal between the points of contact, at the step's start and end
  bool at_start;
  bool solid;  ///< no shell has part in it
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
