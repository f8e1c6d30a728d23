// Element types and their faces. The node order is that of VTK.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <volccd/numerics/types.hpp>

namespace volccd {

/// The values are the cell types of VTK.
enum class ElementType : std::uint8_t {
  none = 0,  ///< an empty slot
  triangle = 5,
  quad = 9,
  tetrahedron = 10,
  hexahedron = 12,
  wedge = 13,
  pyramid = 14,
  polytope = 42  ///< convex, given by its faces
};

const char* to_string(ElementType type);

/// Whether a VTK cell type can be stored in a mesh; false for `none`.
bool is_element_type(std::int64_t vtk_type);

/// Number of vertices of a type; 0 for a polytope, whose number of vertices varies.
int vertex_count(ElementType type);

/// Whether the element is a surface (triangle, quad) rather than a volume.
bool is_shell(ElementType type);

/// Faces of a type with a fixed number of vertices, as a stream {n, i0 .. i(n-1), n, ...} of local vertex numbers, each
/// face in cyclic order. The face stream of a polytope is stored in the mesh.
std::span<const std::uint8_t> face_stream(ElementType type);

/// Calls visit(face) for each face of a face stream, of local vertex numbers or of vertex slots. `face` is the span of
/// its vertices.
template <class T, class Visit>
void visit_faces(std::span<T> stream, Visit&& visit) {
  for (std::size_t at = 0; at < stream.size(); at += 1 + std::size_t{stream[at]})
    visit(stream.subspan(at + 1, stream[at]));
}

}  // namespace volccd
