// Vertex stars whose links are branched coverings of the sphere: every tetrahedron has positive volume, and directions
// are covered several times.
#pragma once

#include <volccd/oracle/cases/hostile_parts.hpp>

namespace volccd::cases {

/// A closed triangulated surface around the origin, whose triangles are counter-clockwise as seen from outside.
struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;
};

/// A double pyramid of 3 to 7 sides or an icosahedron, with some triangles divided. Coordinates are integers up to 12.
Surface sphere(Choices& choices);

/// The link of a star: `sheets` copies of a surface, connected across its edges by permutations of the sheets, most of
/// which are the identity. Vertices around which the product of permutations is not the identity become branch points;
/// several of them give handles. Copies of a point have different distances from the origin, and differ by up to
/// `spread` in each coordinate.
Surface branched_cover(Choices& choices, const Surface& base, int sheets, int spread);

/// Removes the triangles at some vertices, or some single triangles, so that the surface has boundary rings.
void open_rings(Choices& choices, Surface& surface);

/// Removes the triangles at one vertex of a cover, and moves the triangles of the next sheet that have their directions
/// to the front. With two sheets, these directions remain covered once.
void open_over_sheet(Choices& choices, Surface& cover, std::size_t base_triangles);

/// The star with a tetrahedron for each triangle of the link; vertex 0 is its centre, at the origin.
HostileMesh star_over(const Surface& link);

/// A star with a ring of vertices that goes around the axis once, twice and three times, each in a pose of its own,
/// with equal signs of all volumes. Has tetrahedra below the ring, above it as well, or triangles only.
enum class Winding { boundary, inside, shells };
HostileMesh winding_star(Choices& choices, Winding winding);

}  // namespace volccd::cases
