// An explicit finite-element simulation whose contacts are found by this library's pipelines: Algorithm 1 of the paper.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/pipelines/lists/list_policy.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/contact/contact_features.hpp>
#include <volccd/simulation/ledger.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

struct SimulationOptions {
  std::string pipeline = "VolCCD+";  ///< preset that finds pairs of features; `inclusion` decides which touch
  ContactFeatures features = ContactFeatures::all;
  bool adjacent_contacts =
      true;              ///< resist contacts between features of one element or of adjacent elements (inversion)
  bool contacts = true;  ///< false: no queries; of what resists, only walls act

  double step_safety = 0.9;  ///< fraction of ElementForces::stable_step() that a substep takes
  double max_step = kNever;

  /// How the queries of each substep use candidate lists. The simulation does not depend on it.
  ListConfig lists = {.use = ListConfig::Use::automatic};
  int contact_passes = 4;       ///< of detection and response in a substep; then touching features are held apart
  int contact_iterations = 12;  ///< sweeps over the contacts in a pass
  /// Gap at which contacts are resisted (metres). Negative: 1 % of the shortest edge, and at most a tenth of a shell's
  /// thickness.
  double separation = -1;
  /// Pairs of objects that do not collide. A pair of equal ids: the object does not collide with itself.
  std::vector<std::pair<std::int32_t, std::int32_t>> excluded;

  /// Splitting and merging are tested once in this many substeps.
  int topology_interval = 5;
  bool splitting = true, merging = true, cutting = true;  ///< according to the materials and Model::cuts
};

/// Numbers of events since the last call of Simulation::drain_counts().
struct SimulationCounts {
  std::uint64_t substeps = 0, queries = 0;
  /// Contacts that got a response, by class (ContactClass): between objects, within one object, between adjacent
  /// elements or within one element.
  std::uint64_t inter = 0, intra = 0, adjacent = 0;
  std::uint64_t leaving = 0;     ///< contacts of overlapping features that move apart: not resisted
  std::uint64_t ignored = 0;     ///< contacts that are not resisted (ContactVerdict::ignore)
  std::uint64_t held = 0;        ///< vertices held apart because the passes did not suffice, summed over substeps
  std::uint64_t unresolved = 0;  ///< pairs of features that still touch or cross at the end of a substep
  std::uint64_t splits = 0, breaks = 0, merges = 0, cuts = 0, edits = 0;
};

/// A query: the motion from `start` to `end` was searched for pairs of features within the separation.
struct AskedQuery {
  std::span<const Vec3> start, end;  ///< by vertex
  double separation = 0;
};

/// Leapfrog integration: each substep computes forces, updates velocities, resolves contacts and updates positions;
/// then come cuts, merging, breaking and splitting. A contact is resisted by an impulse at the time t' at which the
/// features come within the separation. No feature passes through another, except for the pairs that
/// SimulationCounts::unresolved counts. Bodies that overlap from the start may separate, but do not penetrate further.
///
/// Shells collide as prisms of their thickness; a contact acts on the vertices of the shell. Walls act on vertices (for
/// a shell, those of its mid-surface) with the wall's friction and the body's restitution. A rigid body with a fixed
/// vertex does not move, and one with a guide follows its path; in contacts both count as infinitely heavy.
///
/// Holds the model and all state. Deterministic: bit for bit the same for any number of workers. Not thread-safe.
class Simulation {
 public:
  /// Throws InputError for an inconsistent model (lengths, indices, objects without a body, a vertex of two rigid
  /// bodies), ConfigError for invalid options.
  Simulation(Model model, SimulationOptions options, Executor& executor);
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Runs substeps, of equal length where the stable step allows, and ends exactly at `time`. Throws Error when a
  /// coordinate is no longer finite. `go_on` is called after each substep but the last, with the time reached. If it
  /// returns false, the simulation stops there, and advance_to() returns false. To
  /// continue as without the interruption, read back a state that was archived before.
  bool advance_to(double time, const std::function<bool(double time)>& go_on = {});

  double time() const;
  const Topology& topology() const;
  std::span<const Vec3> positions() const;   ///< by vertex, unused vertices included
  std::span<const Vec3> velocities() const;  ///< by vertex, at the middle of the last substep
  /// By vertex: its position when the last advance_to() began. For a vertex that is new since then, p - s v (Section
  /// 6.3), where p is its position, s the time since then, and v the mean velocity of the material that it came from.
  std::span<const Vec3> start_positions() const;
  /// The first query of the last substep: the motion before any response; nothing without contacts
  /// (SimulationOptions::contacts). Vertices that are new since then have the positions there of the vertices
  /// from which they were made. Before the first query: the initial positions at both ends.
  std::optional<AskedQuery> last_query() const;
  /// The thickness by element slot; 0 for solids and empty slots.
  std::vector<double> thickness() const;
  double mass(Index vertex) const;

  const Ledger& ledger() const;
  SimulationCounts drain_counts();

  /// Writes all state that changes, or reads it into a simulation made from the same model and options, which then
  /// continues bit for bit as the one that wrote it. Throws InputError for the state of a different simulation.
  void archive(Archive& archive);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volccd::simulation
