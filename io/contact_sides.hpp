// The elements and objects on the two sides of a contact.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <volccd/mesh/mesh.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// Of one feature of a contact: the element Contact::elements as its id, and the object of that element. Both are -1
/// where the contact names no element; an element's id is not negative otherwise, an object may be.
struct ContactSide {
  std::int64_t object = -1, element = -1;

  friend bool operator==(const ContactSide&, const ContactSide&) = default;
};

/// Of the first feature (vertex, edge 1) and the second (triangle, edge 2).
std::array<ContactSide, 2> contact_sides(const Contact& contact, const Mesh& mesh);

/// Contacts between two objects, or within one.
struct ObjectPairCount {
  std::uint64_t vf = 0, ee = 0;
  int first_step = 0;    ///< of the earliest contact
  double first_toi = 2;  ///< its time in that step
};

/// By the objects of ContactSide, the smaller one first.
using ObjectPairs = std::map<std::pair<std::int64_t, std::int64_t>, ObjectPairCount>;

/// Adds the contacts of a step. Steps come in ascending order.
void count_object_pairs(int step, std::span<const Contact> contacts, const Mesh& mesh, ObjectPairs& pairs);

}  // namespace volccd
