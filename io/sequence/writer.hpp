// Writing a sequence file: VTKHDF, temporal UnstructuredGrid, one frame at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/metadata.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// Error text: why a sequence cannot be written to a device, a FIFO or the standard output.
inline constexpr const char* kSequenceIsNoStream = "a sequence (HDF5) is not written from front to back";

/// Optional data of a frame beside points and cells. Each array is given for every frame or for none.
struct FrameFields {
  std::span<const Vec3> velocity = {};     ///< one per point, in length units per time unit
  std::span<const double> thickness = {};  ///< one per cell of the frame; 0 for volumes
  /// The last query that a solver asked before this frame: the positions of the points at its start and at its end, one
  /// per point and both or neither, and its separation, which is finite and not negative.
  std::span<const Vec3> query_start = {}, query_end = {};
  double query_separation = 0;
};

/// `temporal`: any number of frames, VTKHDF 2.x; VTK opens it from version 9.3 on. `single`: one frame without the
/// group "Steps", VTKHDF 1.0, its time in FieldData/TimeValue, which SequenceReader ignores; VTK opens it from version
/// 9.1 on. The single form has no polytopes.
enum class SequenceForm { temporal, single };

/// Writes the layout that SequenceReader reads and ParaView opens: version 2.2, one piece per frame, 64-bit ids, arrays
/// with chunks, shuffle filter and gzip compression, attributes of fixed-length ASCII (UTF-8 if a text is not ASCII).
/// Consecutive frames with equal cells share one stored topology. A sequence with polytopes has the face arrays and the
/// version number of VTKHDF 2.5.
///
/// Atomic, by the rules of OutputFile, and for regular files only: everything is written to a temporary file in the
/// same directory, which finish() writes to disk and renames. Without finish(), no file is left behind. Memory: buffers
/// for one frame, and the cells of the last frame. The same calls write the same bytes.
///
/// Errors: InputError with `file` and the dataset for data that SequenceReader would refuse (a number that is not
/// finite, a vertex out of range or twice in a cell, a repeated id, times that are not ascending, arrays of wrong
/// length; a second frame or a polytope in the single form), and for errors of the operating system. After an error the
/// writer cannot be used any more. Not thread-safe.
class SequenceWriter {
 public:
  /// `point_ids` are distinct and not negative, in any order; vertex slots of the cells are indices into `point_ids`.
  SequenceWriter(const std::string& file, std::span<const std::int64_t> point_ids,
                 const SequenceMetadata& metadata = {}, SequenceForm form = SequenceForm::temporal);
  SequenceWriter(SequenceWriter&&) noexcept;
  ~SequenceWriter();

  void write_frame(double time, std::span<const Vec3> points, const SequenceCells& cells,
                   const FrameFields& fields = {});

  /// Completes the file. At least one frame must have been written. `incomplete` is the reason why the file ends before
  /// the last intended frame (SequenceMetadata::incomplete); empty if the file is complete.
  void finish(const std::string& incomplete = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
