// Elements whose nodes repeat: which element they are.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/element_type.hpp>

namespace volccd::detail {

/// What is left of an element whose nodes repeat. `type` is `none`, and `problem` says why, where no element is left.
struct CollapsedElement {
  ElementType type = ElementType::none;
  std::vector<Index> vertices;  ///< distinct; VTK's node order, with the orientation of the element given
  std::vector<Index> faces;     ///< of a polytope: {n, v0 .. v(n-1), n, ...}
  std::string problem;
};

/// The element that an element of a fixed type with repeated nodes is. Repeated neighbours are dropped from each face,
/// then faces with fewer than three nodes, then pairs of faces with the same nodes in opposite order. What remains is a
/// triangle, a tetrahedron, a pyramid or a wedge, or a polytope, if it is the boundary of one polyhedron in which at
/// least three faces meet at every vertex. A hexahedron whose last five nodes are one is the tetrahedron of its first
/// four, the convention of LS-DYNA. A triangle with a repeated node, a solid flattened to a sheet, and a solid pinched
/// at a vertex are no elements. Pre: `nodes` has the number of vertices of `type`, which is not polytope.
CollapsedElement collapse_element(ElementType type, std::span<const Index> nodes);

}  // namespace volccd::detail
