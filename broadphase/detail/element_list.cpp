#include <volccd/broadphase/detail/element_list.hpp>

#include <algorithm>

namespace volccd::detail {

void list_elements(const Mesh& mesh, std::vector<Index>& slots) {
  slots.clear();
  slots.reserve(mesh.element_count());
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) slots.push_back(o);
}

void update_elements(const Mesh& mesh, std::span<const Index> touched, std::vector<Index>& slots) {
  std::erase_if(slots, [&](Index o) { return std::binary_search(touched.begin(), touched.end(), o); });
  for (const Index o : touched)
    if (mesh.is_live(o)) slots.push_back(o);
}

}  // namespace volccd::detail
