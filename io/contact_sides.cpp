#include <volccd/io/contact_sides.hpp>

#include <algorithm>

namespace volccd {

std::array<ContactSide, 2> contact_sides(const Contact& contact, const Mesh& mesh) {
  std::array<ContactSide, 2> sides;
  for (std::size_t i = 0; i < 2; ++i)
    if (const Index o = contact.elements[i]; o != kNone) sides[i] = {mesh.object(o), mesh.element_id(o)};
  return sides;
}

void count_object_pairs(int step, std::span<const Contact> contacts, const Mesh& mesh, ObjectPairs& pairs) {
  for (const Contact& contact : contacts) {
    const std::array<ContactSide, 2> sides = contact_sides(contact, mesh);
    ObjectPairCount& count = pairs[std::minmax(sides[0].object, sides[1].object)];
    if (count.vf + count.ee == 0) count.first_step = step;
    ++(contact.kind == FeatureKind::vf ? count.vf : count.ee);
    if (count.first_step == step) count.first_toi = std::min(count.first_toi, contact.toi);
  }
}

}  // namespace volccd
