// Reading a sequence file: VTKHDF, UnstructuredGrid, with or without steps.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/metadata.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd {

/// A sequence of S steps on one set of n points, whose cells come and go. Streams: holds the tables of the steps and a
/// buffer for one step, never more, so that a file larger than memory can be read.
///
/// Layout: VTKHDF 1.x and 2.x as VTK and ParaView write it, one piece a step ("Steps/NumberOfParts" = 1,
/// "Steps/PartOffsets" = the step's topology), the same number of points in every topology. A file without the group
/// "Steps" is one step at time 0. Optional arrays: PointData/GlobalPointIds (else 0, 1, 2, ..), CellData/GlobalCellIds
/// (else 0, 1, 2, .. in each step), CellData/PartId (else 0), PointData/Velocity, CellData/Thickness. Cells: triangle,
/// quad, tetrahedron, hexahedron, wedge, pyramid, and polyhedron as VTKHDF 2.5 stores it (FaceConnectivity,
/// FaceOffsets, PolyhedronToFaces, PolyhedronOffsets).
///
/// Vertices are presented by ascending GlobalPointIds, whatever their order in the file, because slot order is id order
/// in a Mesh: vertex slot v has id point_ids()[v], and points, velocities and connectivity are renumbered to fit. Cells
/// stay in the order of the file.
///
/// A cell whose nodes repeat, as programs for finite elements write a wedge as a hexahedron or a triangle as a quad, is
/// read as the element that it is: a triangle, tetrahedron, pyramid or wedge, or a polytope where only some edges of a
/// solid have no length (mesh/detail/collapse_element.hpp). A cell of which no element is left is refused.
///
/// Errors: InputError with the file, the dataset, and the row of that dataset (of a table in Steps: the step); where a
/// point or a cell is wrong, the text names its id and the step. The constructor checks structure: all shapes, types,
/// offsets and slices of every step, times, point ids. The contents of a step are checked when it is read: finite
/// numbers, thickness >= 0, known types with the right number of vertices, connectivity in range, ids distinct and not
/// negative. Nothing is allocated on the strength of a declared size that the stored bytes do not bear out.
///
/// One thread at a time.
class SequenceReader {
 public:
  explicit SequenceReader(const std::string& file);
  SequenceReader(SequenceReader&&) noexcept;
  SequenceReader& operator=(SequenceReader&&) noexcept;
  ~SequenceReader();

  const std::string& file() const;
  const SequenceMetadata& metadata() const;

  /// At least 1.
  int step_count() const;
  /// Strictly ascending, finite.
  double time(int step) const;

  Index point_count() const;
  /// [point_count()], strictly ascending.
  std::span<const std::int64_t> point_ids() const;
  /// Vertex slot of each point of the file, in the file's order.
  std::span<const Index> slot_of_point() const;

  Index cell_count(int step) const;
  /// Which of the stored topologies the step uses.
  int topology_index(int step) const;
  /// Whether both steps take all their cells, with parts and ids, from the same rows of the file.
  bool same_cells(int step, int other) const;
  bool has_velocity() const;
  bool has_thickness() const;

  /// Replaces the contents of the vector or the cells, whose memory is used again.
  void read_points(int step, std::vector<Vec3>& points);
  void read_velocity(int step, std::vector<Vec3>& velocity);      ///< has_velocity()
  void read_thickness(int step, std::vector<double>& thickness);  ///< has_thickness(); per cell of the step
  void read_cells(int step, SequenceCells& cells);

  /// Cells of the last read_cells() whose nodes repeat in the file: how many, by type in the file and type read.
  const std::map<std::pair<ElementType, ElementType>, std::uint64_t>& collapsed_cells() const;

  /// Reads everything once, a step at a time: throws what reading would throw.
  void check_contents();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
