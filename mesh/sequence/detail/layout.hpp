// Where the arrays of each step lie in a sequence file: the tables of the group Steps, checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/detail/hdf5_file.hpp>

namespace volccd::detail {

/// A dataset and the first row of each step there, as the table says that is named (empty in a file without steps).
struct StepArray {
  Hdf5Dataset data;
  std::vector<std::int64_t> first;
  std::string table;
};

/// Polyhedra as in VTKHDF 2.5. A topology has `faces` faces, numbered from 0 in PolyhedronToFaces; FaceOffsets has one
/// entry more and, like Offsets, starts again at 0; PolyhedronOffsets has an entry for every cell, of whatever type,
/// and one more.
struct PolyhedronLayout {
  std::vector<std::int64_t> faces, face_connectivity_ids, to_face_ids;  ///< per topology
  StepArray face_connectivity, face_offsets, to_faces, offsets;
};

/// Tables are per step, counts per topology. After read_layout every slice of every step lies within its dataset.
struct SequenceLayout {
  std::vector<double> times;
  std::int64_t points = 0;
  std::vector<std::int64_t> topology;
  std::vector<std::int64_t> cells, connectivity_ids;
  StepArray positions, types, offsets, connectivity;
  std::optional<StepArray> point_ids, velocity, cell_ids, part_ids, thickness;
  std::optional<PolyhedronLayout> polyhedra;

  std::size_t steps() const { return times.size(); }
  std::int64_t cells_of(int step) const { return cells[topology_of(step)]; }
  std::size_t topology_of(int step) const { return static_cast<std::size_t>(topology[static_cast<std::size_t>(step)]); }
};

/// Throws InputError for whatever does not fit. O(steps + topologies).
SequenceLayout read_layout(const Hdf5File& file);

}  // namespace volccd::detail
