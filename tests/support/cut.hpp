// A part of a mesh, with the stars at its cut.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/step.hpp>

namespace volccd::test {

/// The elements of a topology for which keep(slot) is true, in the same slots and with the same vertices.
struct Cut {
  template <class Keep>
  Cut(const Topology& whole, Keep&& keep)
      : topology(whole.mesh(), whole.features().edge_set()), complete(whole.mesh().vertex_count(), 0) {
    const Mesh& mesh = whole.mesh();
    TopologyEdit rest, others;
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o) && !keep(o)) rest.removed.push_back(o);
    topology.apply(rest);
    const auto count = [](const Topology& t, Index v) { return t.features().vertex_elements(v).size(); };
    for (Index v = 0; v < mesh.vertex_count(); ++v) complete[v] = count(topology, v) == count(whole, v) ? 1 : 0;
    const auto is_cut = [&](Index v) { return complete[v] == 0 && count(topology, v) > 0; };
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o) && std::ranges::none_of(mesh.vertices(o), is_cut)) others.removed.push_back(o);
    if (others.removed.size() == mesh.element_count()) return;
    cut_stars.emplace(mesh, whole.features().edge_set());
    cut_stars->apply(others);
  }

  Piece piece() const { return {.complete = complete, .cut_stars = cut_stars ? &*cut_stars : nullptr}; }

  Topology topology;
  std::vector<std::uint8_t> complete;
  std::optional<Topology> cut_stars;
};

}  // namespace volccd::test
