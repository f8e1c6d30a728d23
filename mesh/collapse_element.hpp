// Determines which element a cell with repeated nodes represents.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/element_type.hpp>

namespace volccd::detail {

/// The element that a cell with repeated nodes represents. If there is none, `type` is `none`, and `problem` is the
/// reason.
struct CollapsedElement {
  ElementType type = ElementType::none;
  std::vector<Index> vertices;  ///< distinct, in VTK's node order; the orientation is that of the cell
  std::vector<Index> faces;     ///< for a polytope: {n, v0 .. v(n-1), n, ...}
  std::string problem;
};

/// The element that a cell of a fixed type with repeated nodes represents. First, repeated neighbours are removed from
/// each face, then faces with fewer than three nodes, then pairs of faces with the same nodes in opposite order. If the
/// remaining faces form the boundary of one polyhedron, with at least three faces at every vertex, the result is a
/// tetrahedron, a pyramid, a wedge or a polytope; a quad may become a triangle. A hexahedron whose last five nodes are
/// equal is the tetrahedron of its first four nodes, by the convention of LS-DYNA. There is no element for a triangle
/// with a repeated node, a solid that is flattened to a sheet, and a solid that is pinched at a vertex. Pre: `nodes`
/// has as many entries as `type` has vertices; `type` is not polytope.
CollapsedElement collapse_element(ElementType type, std::span<const Index> nodes);

}  // namespace volccd::detail
