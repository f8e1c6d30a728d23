// Checks whether a mesh can store an element description.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// Describes what is wrong with the element, for a mesh of `vertex_count` vertices; empty if the element is valid. The
/// id of the element is not checked. The text names vertices by their `ids` (indexed by slot), or by their slots if
/// `ids` is empty. O(n) for types with a fixed number of vertices, O(n log n) for a polytope.
std::string element_problem(const ElementSpec& element, Index vertex_count, std::span<const std::int64_t> ids = {});

}  // namespace volccd::detail
