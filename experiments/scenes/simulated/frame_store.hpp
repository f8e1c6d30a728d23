// Frames of a simulation on their way to a sequence file.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include <volccd/core/function_ref.hpp>
#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/metadata.hpp>
#include <volccd/simulation/simulation.hpp>

namespace volccd {

/// A moment of a simulation, with what happened since the frame before.
struct Frame {
  double time = 0;
  std::vector<std::int64_t> vertex_ids;     ///< of all vertices there are by now
  std::vector<Vec3> positions, velocities;  ///< a vertex
  /// A vertex that the frame before does not have: where it was then, p' = p - s v (Section 6.3).
  std::vector<Vec3> start_positions;
  SequenceCells cells;            ///< PartId is the object + 1
  std::vector<double> thickness;  ///< a cell; empty without shells

  simulation::SimulationCounts counts;
  simulation::Ledger ledger;
  double seconds = 0;  ///< wall time
};

/// The simulation as it is now, `vertices_before` being the number of vertices at the frame before. `seconds` is left
/// 0.
Frame capture_frame(simulation::Simulation& simulation, Index vertices_before);

/// Writes what is read back when a bake goes on: whole or not at all. Throws InputError with the system's reason.
void write_checkpoint(const std::string& file, FunctionRef<void(std::ostream&)> write);

/// By write_checkpoint().
void write_frame(const std::string& file, const Frame& frame);

/// Throws InputError for a file that is missing or ends early.
Frame read_frame(const std::string& file);

/// Writes frames as a sequence, a frame at a time: all vertices of the last frame at all steps. Before a vertex exists,
/// no cell uses it; its velocity is 0 then, and its place that from which it goes to its first frame. So the motion
/// towards that frame is the one of Section 6.3. `frame_files`: in order. Throws InputError.
void write_frames(const std::vector<std::string>& frame_files, const std::string& file, SequenceMetadata metadata);

}  // namespace volccd
