// Reading a sequence file: VTKHDF, UnstructuredGrid, with or without frames.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/metadata.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// A sequence of S frames on a fixed set of n points, whose cells may change from frame to frame. The reader holds only
/// the tables of the frames and a buffer for one frame, so that it can read a file larger than memory.
///
/// Layout: VTKHDF 1.x and 2.x as VTK and ParaView write it, with one piece per frame ("Steps/NumberOfParts" = 1,
/// "Steps/PartOffsets" = the topology of the frame) and the same number of points in every topology. A file without the
/// group "Steps" is one frame at time 0. Optional arrays and their defaults: PointData/GlobalPointIds (0, 1, 2, ..),
/// CellData/GlobalCellIds (0, 1, 2, .. in each frame), CellData/PartId (0), PointData/Velocity (none),
/// CellData/Thickness (none), PointData/QueryStart, QueryEnd and QuerySeparation (none). Cells: triangle, quad,
/// tetrahedron, hexahedron, wedge, pyramid, and polyhedron as VTKHDF 2.5 stores it (FaceConnectivity, FaceOffsets,
/// PolyhedronToFaces, PolyhedronOffsets).
///
/// Vertices are sorted by GlobalPointIds, because slots in a Mesh are in the order of ids: vertex slot v has id
/// point_ids()[v], and points, velocities and connectivity are renumbered accordingly. Cells keep the order of the
/// file.
///
/// Finite element programs may write a wedge as a hexahedron, or a triangle as a quad, with repeated nodes. A cell with
/// repeated nodes is read as the element that it represents: a triangle, tetrahedron, pyramid or wedge, or a polytope
/// if only some edges of a solid have zero length (mesh/collapse_element.hpp). A cell that represents no element
/// is refused.
///
/// Errors: InputError with the file, the dataset, and the row in that dataset (for a table in Steps: the frame). If a
/// point or a cell is wrong, the message contains its id and the frame. The constructor checks the structure: all
/// shapes, types, offsets and ranges of every frame, the times, and the point ids. The contents of a frame are checked
/// when it is read: finite numbers, thickness >= 0, known types with the right number of vertices, connectivity in
/// range, ids distinct and not negative. Memory is never allocated for a declared size that exceeds what the stored
/// bytes can contain.
///
/// Not thread-safe.
class SequenceReader {
 public:
  explicit SequenceReader(const std::string& file);
  SequenceReader(SequenceReader&&) noexcept;
  SequenceReader& operator=(SequenceReader&&) noexcept;
  ~SequenceReader();

  const std::string& file() const;
  const SequenceMetadata& metadata() const;

  /// Number of frames, at least 1.
  int frame_count() const;
  /// Time of a frame. Times are finite and strictly ascending.
  double time(int frame) const;

  Index point_count() const;
  /// Ids of the vertices, [point_count()], strictly ascending.
  std::span<const std::int64_t> point_ids() const;
  /// Vertex slot of each point of the file, in the file's order.
  std::span<const Index> slot_of_point() const;

  Index cell_count(int frame) const;
  /// Index of the stored topology that the frame uses.
  int topology_index(int frame) const;
  /// Whether both frames read all their cells, including objects and ids, from the same rows of the file.
  bool same_cells(int frame, int other) const;
  bool has_velocity() const;
  bool has_thickness() const;
  /// Whether each frame has the last query of the simulation that made it (FrameFields).
  bool has_query() const;

  /// These members replace the contents of their argument and reuse its memory.
  void read_points(int frame, std::vector<Vec3>& points);
  void read_velocity(int frame, std::vector<Vec3>& velocity);      ///< requires has_velocity()
  void read_thickness(int frame, std::vector<double>& thickness);  ///< requires has_thickness(); one value per cell of
                                                                   ///< the frame
  /// The positions at both ends of the last query before a frame; returns its separation, the same at all points, which
  /// is finite and not negative. Requires has_query().
  double read_query(int frame, std::vector<Vec3>& start, std::vector<Vec3>& end);
  void read_cells(int frame, SequenceCells& cells);

  /// Whether the members below can be called: not if the file has polyhedra.
  bool can_read_parts() const;
  /// The same for `count` rows after the first `first` ones, in the order of the file: row i is that of the vertex
  /// slot_of_point()[first + i]. The ids of cells are distinct among these. For readers that divide a frame among them.
  void read_points(int frame, Index first, Index count, std::vector<Vec3>& points);
  double read_query(int frame, Index first, Index count, std::vector<Vec3>& start, std::vector<Vec3>& end);
  void read_cells(int frame, Index first, Index count, SequenceCells& cells);

  /// Numbers of cells with repeated nodes in the last read_cells(), by type in the file and type of the element read.
  const std::map<std::pair<ElementType, ElementType>, std::uint64_t>& collapsed_cells() const;

  /// Reads the contents of all frames, one frame at a time, and throws every error that reading them would throw.
  void check_contents();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
