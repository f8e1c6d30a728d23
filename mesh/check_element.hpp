// Checks whether a mesh can store an element description, and whether values are distinct.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// Describes what is wrong with the element, for a mesh of `vertex_count` vertices; empty if the element is valid. The
/// id of the element is not checked. The text names vertices by their `ids` (indexed by slot), or by their slots if
/// `ids` is empty. O(n) for types with a fixed number of vertices, O(n log n) for a polytope.
std::string element_problem(const ElementSpec& element, Index vertex_count, std::span<const std::int64_t> ids = {});

/// Position of the second occurrence of the smallest value that occurs several times; values.size() if all are
/// distinct.
template <class T>
std::size_t find_repeated(std::span<const T> values) {
  std::vector<T> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice == sorted.end()) return values.size();
  const auto other = std::find(std::find(values.begin(), values.end(), *twice) + 1, values.end(), *twice);
  return static_cast<std::size_t>(other - values.begin());
}

}  // namespace volccd::detail
