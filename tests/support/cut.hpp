// A part of a mesh, with the elements around it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/step.hpp>

namespace volccd::test {

/// The elements of a topology for which keep(slot) is true, with the same vertices.
struct Cut {
  template <class Keep>
  Cut(const Topology& whole, Keep&& keep) : complete(whole.mesh().vertex_count(), 1) {
    const Mesh& mesh = whole.mesh();
    const EdgeSet edge_set = whole.features().edge_set();
    Mesh part;
    part.add_vertices(mesh.vertex_ids());
    std::vector<Index> others;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o)) continue;
      if (keep(o))
        part.add_element(mesh.spec(o));
      else
        others.push_back(o);
    }
    topology.emplace(part, edge_set);
    bool halo = false;
    for (const Index o : others) {
      bool meets = false;
      for (const Index v : mesh.vertices(o)) {
        complete[v] = 0;
        meets = meets || !topology->features().vertex_elements(v).empty();
      }
      if (meets) part.add_element(mesh.spec(o)), halo = true;
    }
    if (halo) with_halo.emplace(std::move(part), edge_set);
  }

  Piece piece() const { return {.complete = complete, .with_halo = with_halo ? &*with_halo : nullptr}; }

  std::optional<Topology> topology, with_halo;
  std::vector<std::uint8_t> complete;
};

}  // namespace volccd::test
