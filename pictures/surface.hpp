// The triangles that a picture of a mesh shows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd {

/// Edge i of a triangle goes from corner i to corner i + 1 (mod 3).
struct SurfaceTriangle {
  std::array<Index, 3> corners{};  ///< into Surface::points
  std::uint16_t colour = 0;        ///< whatever the caller gave the cell
  std::uint8_t element_edges = 0;  ///< bit i: edge i is an edge of an element, not a diagonal
  std::uint8_t feature_edges = 0;  ///< bit i: edge i is a crease, a rim, a border between colours, or the rim of a cut
  bool section = false;            ///< lies in a cutting plane
};

/// Seen from both sides.
struct Surface {
  std::vector<Vec3> points;
  std::vector<SurfaceTriangle> triangles;
  /// Unit normals at the corners of each triangle, all three on the side of the triangle's own normal (the right-hand
  /// rule); zero for a triangle without area.
  std::vector<std::array<Eigen::Vector3f, 3>> normals;
};

/// Vertices in use, ascending, but for those of fragments: pieces that hang together by common vertices, and for every
/// part in them have less than `least_share` of its cells, and are not its largest piece. They may fly far from
/// anything that a picture is meant to show. O(cells) expected.
std::vector<Index> vertices_of_bodies(const SequenceCells& cells, std::size_t vertex_count, double least_share = 0.05);

/// Takes away what lies at positive signed distance: normal . x > offset.
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

/// Shells as they are, and of the volumes the triangles that belong to one element only (faces split as Features has
/// it). Corners of neighbouring triangles whose normals differ by less than `crease` degrees share a mean normal;
/// a crease that counts as a feature is 15 degrees sharper. `colours`: one a cell. `points` is one a vertex slot.
/// O(cells) expected.
Surface surface_of(const SequenceCells& cells, std::span<const Vec3> points, std::span<const std::uint16_t> colours,
                   double crease = 50);

/// Clips the surface and closes it over the volumes: each element that a plane goes through gives a face of the section
/// (the hull of what the plane has in common with its edges). Several planes: what none of them takes away is left.
void cut(Surface& surface, const SequenceCells& cells, std::span<const Vec3> points,
         std::span<const std::uint16_t> colours, std::span<const CuttingPlane> planes);

}  // namespace volccd
