// Positions of the arrays of each step in a sequence file, from the tables of the group Steps, which are checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <volccd/io/hdf5/detail/hdf5_file.hpp>

namespace volccd::detail {

/// A dataset and its first row for each step. The rows are from the table named `table` (empty in a file without
/// steps).
struct StepArray {
  Hdf5Dataset data;
  std::vector<std::int64_t> first;
  std::string table;

  /// Replaces `out` by `count` rows of a step.
  template <class T>
  void read(std::size_t step, std::int64_t count, std::vector<T>& out) const {
    data.read(first[step], count, out);
  }
  /// Throws an InputError for row i of a step.
  [[noreturn]] void fail(std::size_t step, std::size_t i, const std::string& problem) const {
    data.fail(first[step] + static_cast<std::int64_t>(i), problem);
  }
};

/// Polyhedra as in VTKHDF 2.5. A topology has `faces` faces, which PolyhedronToFaces numbers from 0. FaceOffsets has
/// one more entry and, like Offsets, starts at 0 for each topology. PolyhedronOffsets has one entry for every cell of
/// any type, and one more.
struct PolyhedronLayout {
  std::vector<std::int64_t> faces, face_connectivity_ids, to_face_ids;  ///< one entry per topology
  StepArray face_connectivity, face_offsets, to_faces, offsets;
};

/// Tables have one entry per step, counts one per topology. After read_layout() every range of every step is within its
/// dataset.
struct SequenceLayout {
  std::vector<double> times;
  std::int64_t points = 0;
  std::vector<std::int64_t> topology;
  std::vector<std::int64_t> cells, connectivity_ids;
  StepArray positions, types, offsets, connectivity;
  std::optional<StepArray> point_ids, velocity, cell_ids, part_ids, thickness;
  std::optional<StepArray> query_start, query_end, query_separation;
  std::optional<PolyhedronLayout> polyhedra;

  std::size_t steps() const { return times.size(); }
  std::int64_t cells_of(std::size_t step) const { return cells[topology_of(step)]; }
  std::size_t topology_of(std::size_t step) const { return static_cast<std::size_t>(topology[step]); }
};

/// Reads and checks the layout. Throws InputError if anything is inconsistent. O(steps + topologies).
SequenceLayout read_layout(const Hdf5File& file);

}  // namespace volccd::detail
