// How close two bodies can be placed without touching.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Triangles of the faces of all elements, as vertex indices. A triangle occurs once for each element that has it.
std::vector<std::array<Index, 3>> face_triangles(const Shape& shape);

/// Mean length of the edges of all elements, face diagonals not counted; each edge once.
double mean_edge_length(const Shape& shape);

/// How far body b, with its positions as given, must be moved along coordinate axis `axis` to lie just beyond body a
/// (negative if there is room already): the largest height difference between a vertex of one and a triangle of the
/// other above or below it, or between two edges that cross in projection. If their projections do not overlap, the
/// shift that separates their boxes. `cell` > 0: size of the search grid, about an edge length. Takes time about
/// proportional to the number of triangles.
double touching_shift(std::span<const Vec3> a, std::span<const Vec3> b,
                      const std::vector<std::array<Index, 3>>& triangles, int axis, double cell);

}  // namespace volccd
