// Small meshes with positions, of every element type: for tests, examples, built-in scenes.
#pragma once

#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// A description of a mesh that can still be extended: element specs and positions, not yet a Mesh.
struct Shape {
  std::vector<Vec3> positions;
  std::vector<ElementSpec> elements;

  /// Appends another shape: its vertices and element ids follow the present ones, and all its elements get the object
  /// `object`.
  Shape& append(const Shape& other, std::int32_t object);
  /// Moves all positions.
  Shape& translate(const Vec3& by);
  /// Makes the mesh, with vertex ids 0, 1, 2, ...
  Mesh mesh() const;
};

/// A block of nx * ny * nz unit cells at the origin, where each cell is one hexahedron, is divided into 6 tetrahedra
/// (Kuhn), 2 wedges, or 6 pyramids (with a vertex at its centre), or is one polytope; ElementType::triangle and quad
/// give the sheet z = 0 of nx * ny cells. The mesh is conforming. Volumes are positive in VTK's node order.
Shape block(ElementType type, int nx, int ny, int nz);

/// A row of cells of every volume type (in x: hexahedron, two wedges, six pyramids, polytope, six tetrahedra),
/// connected at their common vertices, and shells on its top (triangles on the first column, quads on the second). It
/// is used to check properties on a mesh of mixed types. 5 x ny x nz cells. Between cells of different types the
/// diagonals of a common face agree (they go by the smallest vertex), except where a split into tetrahedra or wedges
/// brings its own.
Shape mixed_block(int ny, int nz);

/// The same shape with vertices renumbered and elements reordered by a permutation drawn from `seed`; cyclic orders of
/// faces are kept. Results must not depend on this numbering.
Shape permuted(const Shape& shape, std::uint64_t seed);

/// Positions moved by independent uniform amounts in [-amount, amount]^3.
std::vector<Vec3> jittered(std::span<const Vec3> positions, double amount, std::uint64_t seed);

}  // namespace volccd
