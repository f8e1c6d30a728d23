// Small meshes with positions, of every element type: for tests, examples, built-in scenes.
#pragma once

#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// A mesh description that can still be put together: element specs and positions, not yet a Mesh.
struct Shape {
  std::vector<Vec3> positions;
  std::vector<ElementSpec> elements;

  /// Appends another shape (its vertices after the present ones, its element ids after the present ones), as object
  /// `object` throughout.
  Shape& append(const Shape& other, std::int32_t object);
  /// Moves all positions.
  Shape& translate(const Vec3& by);
  /// Vertex ids 0, 1, 2, ...
  Mesh mesh() const;
};

/// A block of nx * ny * nz unit cells at the origin, each cell one hexahedron, or split into 6 tetrahedra (Kuhn), 2
/// wedges, or 6 pyramids (a vertex at its centre), or held as one polytope; ElementType::triangle and quad give the
/// sheet z = 0 of nx * ny. All splits conform from cell to cell. Volumes are positive by VTK's node order.
Shape block(ElementType type, int nx, int ny, int nz);

/// A row of cells of every volume type (in x: hexahedron, two wedges, six pyramids, polytope, six tetrahedra), glued at
/// their common vertices, and shells on its top (triangles on the first column, quads on the second): the mix that
/// properties are checked on. 5 x ny x nz cells. Between cells of different types the diagonals of a common face agree
/// (they go by the smallest vertex), except where a split into tetrahedra or wedges brings its own.
Shape mixed_block(int ny, int nz);

/// The same shape with vertices renumbered and elements reordered by a permutation drawn from `seed`; cyclic orders of
/// faces are kept. What a mesh means must not depend on its numbering.
Shape permuted(const Shape& shape, std::uint64_t seed);

/// Positions moved by independent uniform amounts in [-amount, amount]^3.
std::vector<Vec3> jittered(std::span<const Vec3> positions, double amount, std::uint64_t seed);

}  // namespace volccd
