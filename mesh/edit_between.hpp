// The edit that turns the elements of a mesh into other ones.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <volccd/mesh/topology.hpp>

namespace volccd {

/// The edit that turns the elements of `mesh` into n others, which are given by functions of 0 <= i < n: id(i),
/// distinct; is_same(i, o), whether the element in slot o, which has the same id, agrees in everything else; spec(i).
/// An element without a counterpart, or whose counterpart differs, is removed; added elements are in ascending order of
/// i. The edit adds no vertices. Expected time O(elements + n).
template <class Id, class IsSame, class Spec>
TopologyEdit edit_between(const Mesh& mesh, std::size_t n, Id&& id, IsSame&& is_same, Spec&& spec) {
  TopologyEdit edit;
  std::vector<char> stays(mesh.element_slots(), 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Index o = mesh.find_element(id(i));
    if (o != kNone && is_same(i, o))
      stays[o] = 1;
    else
      edit.added.push_back(spec(i));
  }
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && !stays[o]) edit.removed.push_back(o);
  return edit;
}

}  // namespace volccd
