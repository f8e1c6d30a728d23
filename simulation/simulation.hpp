// Explicit finite elements in time, contacts from this library's pipelines: Algorithm 1 of the paper.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/contact_features.hpp>
#include <volccd/simulation/ledger.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

struct SimulationOptions {
  std::string pipeline = "VolCCD+";  ///< preset: finds the pairs of features; `inclusion` tells which of them touch
  ContactFeatures features = ContactFeatures::all;
  bool adjacent_contacts =
      true;              ///< resist contacts between features of one element or of adjacent elements (inversion)
  bool contacts = true;  ///< false: no queries at all; walls stay

  double step_safety = 0.9;  ///< of ElementForces::stable_step()
  double max_step = kNever;

  /// A query spans the positions at the last one and those after this many substeps; what it finds, and what comes near
  /// next if all goes on as it does, is looked after in each substep until the next. 1: each substep has its own query.
  /// advance_to() ends with a query. Worth having while nothing moves far (a fifth of an edge) between queries.
  int substeps_per_query = 1;
  int contact_passes = 4;       ///< of detection and response a query; then what remains is kept apart as it was
  int contact_iterations = 12;  ///< sweeps over the contacts in a pass
  /// Gap that contacts keep (metres). Negative: 1 % of the shortest edge, and at most a tenth of a shell's thickness.
  double separation = -1;
  /// Pairs of objects that do not collide (equal: not with itself).
  std::vector<std::pair<std::int32_t, std::int32_t>> excluded;

  /// Splitting and merging are looked at when at least this many substeps have passed, and at a query.
  int topology_interval = 5;
  bool splitting = true, merging = true, cutting = true;  ///< as the materials and Model::cuts have it
};

/// Since the last call of Simulation::take_counts().
struct SimulationCounts {
  std::uint64_t substeps = 0, queries = 0, retests = 0;
  /// Contacts that met a response, by kind: of different objects; of one object; of adjacent elements (or one).
  std::uint64_t inter = 0, intra = 0, adjacent = 0;
  std::uint64_t leaving = 0;  ///< of something that overlaps and comes out: let go
  std::uint64_t ignored = 0;  ///< not resisted by the options
  std::uint64_t held = 0;     ///< substeps times vertices that were held as they were, because passes did not suffice
  std::uint64_t unresolved = 0;  ///< features that touch or cross at the end of a query all the same
  std::uint64_t splits = 0, breaks = 0, merges = 0, cuts = 0, edits = 0;
};

/// Leapfrog: forces, a kick of the velocities, contacts, positions; then cuts, merging, breaking and splitting.
/// Contacts are impulses at the time t' at which the features come within the separation; nothing passes through
/// anything, but what SimulationCounts::unresolved counts. What overlaps from the start is let out and not let in.
///
/// Shells collide as prisms of their thickness; a contact acts on the vertices of the shell. Walls act on vertices (of
/// a shell: its middle) with their own friction and the part's restitution. A rigid part of which a vertex is fixed
/// stands still.
///
/// Holds the model and all state. Deterministic: the same bits for any number of workers. One thread at a time.
class Simulation {
 public:
  /// Throws InputError for a model that does not hold together (lengths, indices, objects without a part, a vertex of
  /// two rigid parts), ConfigError for options.
  Simulation(Model model, SimulationOptions options, Executor& executor);
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// As many substeps as it takes, of equal length where the stable step allows; ends exactly at `time`. Throws Error
  /// when a coordinate is no longer finite. `go_on` is asked after each substep but the last, with the time reached;
  /// where it says no, the simulation stays there, perhaps before a query that is due, and the result is false. To go
  /// on as if nothing had happened, read back a state that was archived before.
  bool advance_to(double time, const std::function<bool(double time)>& go_on = {});

  double time() const;
  const Topology& topology() const;
  std::span<const Vec3> positions() const;   ///< a vertex of the mesh, also of vertices that no element uses any more
  std::span<const Vec3> velocities() const;  ///< in the middle of the last substep
  /// A vertex: where it was when the last advance_to() began. For a vertex that is new since then p - s v
  /// (Section 6.3), s being the time since, v the mean velocity of the matter that it came from.
  std::span<const Vec3> start_positions() const;
  /// An element slot; 0 for solids and empty slots.
  std::vector<double> thickness() const;
  double mass(Index vertex) const;

  const Ledger& ledger() const;
  SimulationCounts take_counts();

  /// Writes everything that changes, or reads it back into a simulation made from the same model and options: it goes
  /// on bit for bit as the one that wrote. Throws InputError for what was written by another.
  void archive(Archive& archive);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volccd::simulation
