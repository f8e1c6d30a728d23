// How close two bodies can be put before they touch.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Triangles of the faces of all elements, vertex indices, each as often as elements have it.
std::vector<std::array<Index, 3>> face_triangles(const Shape& shape);

/// Mean length of the edges of all elements, face diagonals not counted; each edge once.
double mean_edge_length(const Shape& shape);

/// How far body b, with its positions as given, must be moved along coordinate axis `axis` to lie just beyond body a
/// (negative if there is room already): the largest height difference between a vertex of one and a triangle of the
/// other above or below it, or between two edges that cross in projection. If the bodies do not face each other
/// anywhere: what parts their boxes. `cell` > 0: size of the search grid, about an edge. Time about proportional to the
/// triangles.
double touching_shift(std::span<const Vec3> a, std::span<const Vec3> b,
                      const std::vector<std::array<Index, 3>>& triangles, int axis, double cell);

}  // namespace volccd
