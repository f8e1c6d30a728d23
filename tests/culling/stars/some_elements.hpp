// Elements for a test to remove.
#pragma once

#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// Slots of live elements, each with the probability `share`.
inline std::vector<Index> some_elements(const Mesh& mesh, Random& random, double share) {
  std::vector<Index> chosen;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && random.uniform() < share) chosen.push_back(o);
  return chosen;
}

}  // namespace volccd::detail
