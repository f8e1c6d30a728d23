// Element types and their faces. Node order is VTK's.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include <volccd/mesh/types.hpp>

namespace volccd {

/// Values are VTK's cell types.
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

/// Whether VTK's number names a type that a mesh can hold; `none` does not count.
bool is_element_type(int vtk_type);

/// Vertices of a type; 0 for a polytope, whose number varies.
int vertex_count(ElementType type);

/// Whether the element is a surface (triangle, quad) rather than a volume.
bool is_shell(ElementType type);

/// Faces of a fixed type as a stream {n, i0 .. i(n-1), n, ...} of local vertex numbers, each face in cyclic order. A
/// polytope has its own stream in the mesh.
std::span<const std::uint8_t> face_stream(ElementType type);

}  // namespace volccd
