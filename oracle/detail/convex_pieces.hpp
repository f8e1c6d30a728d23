// Elements as unions of convex pieces. This file has its own tables of faces, so that it detects a wrong face in the
// mesh module.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// The convex hull of `count` points, a triangle (3) or a tetrahedron (4); either may be degenerate.
struct ConvexPiece {
  std::array<Vec3, 4> points;
  int count;

  std::span<const Vec3> span() const { return {points.data(), static_cast<std::size_t>(count)}; }
};

/// How pieces may deviate from an element's body (its surface and all points that the surface winds around).
enum class Cover {
  within,  ///< the pieces lie in the body
  around   ///< the pieces contain the body
};

/// The triangles of the element's boundary as vertex slots, oriented alike around a volume element.
void boundary_triangles(const Mesh& mesh, Index o, std::vector<std::array<Index, 3>>& triangles);

/// Appends the pieces of element o. Returns whether their union is exactly the body; if not, with Cover::within they
/// cover its surface only.
bool append_pieces(const Mesh& mesh, std::span<const Vec3> positions, Index o, Cover cover,
                   std::vector<ConvexPiece>& pieces);

/// Whether the two elements share a vertex.
bool share_vertex(const Mesh& mesh, Index a, Index b);

}  // namespace volccd::detail
