// Writing a sequence file: VTKHDF, temporal UnstructuredGrid, a step at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/metadata.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd {

/// Why a sequence cannot go to a device, a FIFO or the standard output.
inline constexpr const char* kSequenceIsNoStream = "a sequence (HDF5) is not written from front to back";

/// What a step brings beside points and cells. Either every step has it or none.
struct StepFields {
  std::span<const Vec3> velocity = {};     ///< [points], in length units per time unit
  std::span<const double> thickness = {};  ///< [cells of the step]; 0 for volume cells
};

/// `temporal`: any number of steps, VTKHDF 2.x; VTK opens it from 9.3 on. `single`: one step without the group "Steps",
/// VTKHDF 1.0, its time in FieldData/TimeValue, which SequenceReader leaves aside; VTK opens it from 9.1 on. It has no
/// polytopes.
enum class SequenceForm { temporal, single };

/// Writes the layout that SequenceReader reads and ParaView opens: version 2.2, one piece a step, 64-bit ids, arrays
/// chunked, shuffled and gzipped, attributes of fixed-length ASCII (UTF-8 where a text is not ASCII). A topology is
/// stored once for a run of steps with equal cells. A sequence with polytopes gets the face arrays of VTKHDF 2.5 and
/// that version.
///
/// Atomic, by the rules of OutputFile, and to regular files only: everything goes to a temporary name beside the
/// target, which finish() brings to disk and renames. Without finish() nothing is left behind. Memory: buffers of a
/// step, and the cells of the last.
///
/// Errors: InputError with `file` and the dataset, for what SequenceReader would refuse (a number that is not finite, a
/// vertex out of range or twice in a cell, an id twice, a time that does not ascend, arrays of the wrong length; a
/// second step or a polytope in the single form) and for what the system refuses. After an error the writer is no longer usable. One thread at a time.
class SequenceWriter {
 public:
  /// `point_ids`: distinct, none negative, in any order; vertex slots of the cells are indices into it.
  SequenceWriter(const std::string& file, std::span<const std::int64_t> point_ids, SequenceMetadata metadata = {},
                 SequenceForm form = SequenceForm::temporal);
  SequenceWriter(SequenceWriter&&) noexcept;
  ~SequenceWriter();

  void write_step(double time, std::span<const Vec3> points, const SequenceCells& cells, const StepFields& fields = {});

  /// Completes the file. At least one step must have been written. `incomplete`: why the file ends before the last step
  /// that was meant for it, SequenceMetadata::incomplete; empty: it does not.
  void finish(const std::string& incomplete = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace volccd
