// The triangles that a picture of a mesh shows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// A triangle. Edge i goes from corner i to corner i + 1 (mod 3).
struct SurfaceTriangle {
  std::array<Index, 3> corners{};  ///< into Surface::points
  std::uint16_t colour = 0;        ///< the colour that the caller gave to the cell
  std::uint8_t element_edges = 0;  ///< bit i: edge i is an edge of an element, not a diagonal
  std::uint8_t feature_edges = 0;  ///< bit i: edge i is a crease, a rim, a border between colours, or the rim of a cut
  bool section = false;            ///< lies in a cutting plane
};

/// A set of triangles, which are visible from both sides.
struct Surface {
  std::vector<Vec3> points;
  std::vector<SurfaceTriangle> triangles;
  /// Unit normals at the corners of each triangle, all three on the side of the triangle's own normal (the right-hand
  /// rule); zero for a triangle without area.
  std::vector<std::array<Eigen::Vector3f, 3>> normals;
};

/// Vertices in use, ascending, except for those of fragments, which may fly far from the rest. A fragment is a set of
/// cells connected by common vertices that has, for each object in it, less than `min_share` of the object's cells and
/// is not the object's largest connected piece. O(cells) expected.
std::vector<Index> vertices_of_bodies(const SequenceCells& cells, std::size_t vertex_count, double min_share = 0.05);

/// Removes everything at positive signed distance: normal . x > offset.
struct CuttingPlane {
  Vec3 normal;  ///< unit
  double offset;
};

/// The triangles of shells, and of the volumes those that belong to one element only, in the order of the cells for
/// shells and by their smallest vertex for volumes. Faces are split as Features splits them; the smallest corner comes
/// first, and the direction of rotation is the element's. feature_edges and section are not set. `vertices`: slots.
/// O(cells) expected.
std::vector<SurfaceTriangle> boundary_triangles(const SequenceCells& cells, std::size_t vertices,
                                                std::span<const std::uint16_t> colours);

/// The surface of a mesh: its shells, and those triangles of volume elements that belong to one element only (faces are
/// split as in Features). Corners of neighbouring triangles whose normals differ by less than `crease` degrees share a
/// mean normal; a crease is marked as a feature edge from 15 degrees above that. `colours`: by cell. `points`: by
/// vertex slot. O(cells) expected.
Surface surface_of(const SequenceCells& cells, std::span<const Vec3> points, std::span<const std::uint16_t> colours,
                   double crease = 50);

/// Clips the surface by the planes and closes the section through volume elements: each element that a plane intersects
/// gives a face of the section (the convex hull of the plane's intersections with its edges). With several planes, the
/// parts remain that no plane removes.
void cut(Surface& surface, const SequenceCells& cells, std::span<const Vec3> points,
         std::span<const std::uint16_t> colours, std::span<const CuttingPlane> planes);

}  // namespace volccd
