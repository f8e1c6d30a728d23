// Frames of a simulation, stored in files until the sequence file is written.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include <volccd/core/function_ref.hpp>
#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/metadata.hpp>
#include <volccd/simulation/simulation.hpp>

namespace volccd {

/// The state of a simulation at one time, with counts since the frame before.
struct Frame {
  double time = 0;
  std::vector<std::int64_t> vertex_ids;     ///< of all vertices so far
  std::vector<Vec3> positions, velocities;  ///< by vertex
  /// By vertex that the frame before does not have: its position at that frame, p' = p - s v (Section 6.3).
  std::vector<Vec3> start_positions;
  std::vector<Vec3> query_start, query_end;  ///< by vertex: Simulation::last_query(); empty without contacts
  double query_separation = 0;
  SequenceCells cells;            ///< PartId is the object + 1
  std::vector<double> thickness;  ///< by cell; empty without shells

  simulation::SimulationCounts counts;
  simulation::Ledger ledger;
  double seconds = 0;  ///< wall time
};

/// The present state of the simulation. `vertices_before`: number of vertices at the frame before. `seconds` is 0.
Frame capture_frame(simulation::Simulation& simulation, Index vertices_before);

/// Writes a file from which an interrupted bake continues: completely or not at all. Throws InputError with the
/// system's reason.
void write_checkpoint(const std::string& file, FunctionRef<void(std::ostream&)> write);

/// Writes a frame with write_checkpoint().
void write_frame(const std::string& file, const Frame& frame);

/// Reads a frame. Throws InputError for a file that is missing or ends early.
Frame read_frame(const std::string& file);

/// Writes frames as a sequence, one at a time; all steps have all vertices of the last frame. Before a vertex exists,
/// no cell uses it, its velocity is 0, and its position is start_positions of its first frame, so that the motion to
/// that frame is the one of Section 6.3. `frame_files`: in order. Throws InputError.
void write_frames(const std::vector<std::string>& frame_files, const std::string& file, SequenceMetadata metadata);

}  // namespace volccd
