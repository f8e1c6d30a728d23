// Positions of the arrays of each frame in a sequence file, from the tables of the group Steps, which are checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <volccd/io/hdf5/detail/hdf5_file.hpp>

namespace volccd::detail {

/// A dataset and its first row for each frame. The rows are from the table named `table` (empty in a file without
/// frames).
struct FrameArray {
  Hdf5Dataset data;
  std::vector<std::int64_t> first;
  std::string table;

  /// Replaces `out` by `count` rows of a frame.
  template <class T>
  void read(std::size_t frame, std::int64_t count, std::vector<T>& out) const {
    read_part(frame, 0, count, out);
  }
  /// The same for `count` rows after the first `skip` ones.
  template <class T>
  void read_part(std::size_t frame, std::int64_t skip, std::int64_t count, std::vector<T>& out) const {
    data.read(first[frame] + skip, count, out);
  }
  /// Throws an InputError for row i of a frame.
  [[noreturn]] void fail(std::size_t frame, std::size_t i, const std::string& problem) const {
    data.fail(first[frame] + static_cast<std::int64_t>(i), problem);
  }
};

/// Polyhedra as in VTKHDF 2.5. A topology has `faces` faces, which PolyhedronToFaces numbers from 0. FaceOffsets has
/// one more entry and, like Offsets, starts at 0 for each topology. PolyhedronOffsets has one entry for every cell of
/// any type, and one more.
struct PolyhedronLayout {
  std::vector<std::int64_t> faces, face_connectivity_ids, to_face_ids;  ///< one entry per topology
  FrameArray face_connectivity, face_offsets, to_faces, offsets;
};

/// Tables have one entry per frame, counts one per topology. After read_layout() every range of every frame is within
/// its dataset.
struct SequenceLayout {
  std::vector<double> times;
  std::int64_t points = 0;
  std::vector<std::int64_t> topology;
  std::vector<std::int64_t> cells, connectivity_ids;
  FrameArray positions, types, offsets, connectivity;
  std::optional<FrameArray> point_ids, velocity, cell_ids, part_ids, thickness;
  std::optional<FrameArray> query_start, query_end, query_separation;
  std::optional<PolyhedronLayout> polyhedra;

  std::size_t frames() const { return times.size(); }
  std::int64_t cells_of(std::size_t frame) const { return cells[topology_of(frame)]; }
  std::size_t topology_of(std::size_t frame) const { return static_cast<std::size_t>(topology[frame]); }
};

/// Reads and checks the layout. Throws InputError if anything is inconsistent. O(frames + topologies).
SequenceLayout read_layout(const Hdf5File& file);

}  // namespace volccd::detail
