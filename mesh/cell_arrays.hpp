// Elements given by plain arrays in VTK's layout, and the mesh that they make.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Views of the arrays of n cells in VTK's layout. Vertices are numbered from 0, in VTK's node order. The arrays must
/// outlive the functions below, which copy what they need.
struct CellArrays {
  /// [n] VTK cell types: triangle 5, quad 9, tetrahedron 10, hexahedron 12, wedge 13, pyramid 14, polyhedron 42.
  std::span<const std::uint8_t> types = {};
  /// [n + 1] ascending positions in connectivity: first 0, last its size.
  std::span<const std::int64_t> offsets = {};
  /// Vertices of all cells; of a polyhedron each distinct vertex once.
  std::span<const std::int64_t> connectivity = {};
  std::span<const std::int64_t> ids = {};      ///< [n] distinct; empty: 0 .. n - 1
  std::span<const std::int32_t> objects = {};  ///< [n]; empty: all cells belong to object 0
  /// [n + 1] ascending positions in faces: first 0, last its size. Empty if there are no polyhedra.
  std::span<const std::int64_t> face_offsets = {};
  /// For each polyhedron {k, v0 .. v(k-1), k, ...}: the size of each face and its vertices in cyclic order.
  std::span<const std::int64_t> faces = {};

  std::size_t size() const { return types.size(); }
};

/// Throws InputError (source "cells", dataset = name of the member, index in it) if the lengths of the arrays do not
/// match, offsets do not ascend, a type is none of the above, or a vertex number is negative or above 2^32 - 2.
void check_cells(const CellArrays& cells);

/// The cells as elements, in their order. Throws the InputErrors of check_cells(). O(size of the arrays).
std::vector<ElementSpec> elements_of(const CellArrays& cells);

/// A mesh with `vertices` vertices, with ids 0 .. vertices - 1, in which cell i has slot i. Throws the InputErrors of
/// check_cells() and of Mesh::add_element, whose index is the id of the cell. O(size of the arrays).
Mesh mesh_of(Index vertices, const CellArrays& cells);

}  // namespace volccd
