// Whether an element description is one that a mesh can hold.
#pragma once

#include <string>

#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// What is wrong with the element, for a mesh of `vertex_count` vertices; empty if nothing is. Ids are not looked at.
/// O(n) for fixed types, O(n log n) for a polytope.
std::string element_problem(const ElementSpec& element, Index vertex_count);

}  // namespace volccd::detail
