// Whether an element description is one that a mesh can hold.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// What is wrong with the element, for a mesh of `vertex_count` vertices; empty if nothing is. The id of the element is
/// not looked at. Vertices are named by their `ids`, by slot; without these by their slots. O(n) for fixed types,
/// O(n log n) for a polytope.
std::string element_problem(const ElementSpec& element, Index vertex_count, std::span<const std::int64_t> ids = {});

}  // namespace volccd::detail
