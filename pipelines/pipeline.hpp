// A pipeline: broad phase, element culling, assignment, orphans, flood, feature filters, narrow phase.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>
#include <volccd/pipelines/statistics.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// All memory that a pipeline needs from step to step. One workspace serves one run at a time, and only the pipeline
/// that made it (Pipeline::make_workspace); one made by default serves none until another is moved into it.
class Workspace {
 public:
  Workspace();
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  std::size_t bytes() const;

 private:
  friend class Pipeline;
  struct Data;
  std::unique_ptr<Data> data_;
};

enum class Query {
  all,   ///< every contact of the step
  first  ///< the earliest contact alone (the canonically smallest of equal times); what comes later is pruned
};

/// What a run is asked for.
struct Request {
  Query query = Query::all;
  bool initial_overlaps = false;  ///< list them (StepResult); a query for the first contact lists all of them, too
  /// Fill Statistics::adjacent_pairs where the broad phase emits adjacent pairs. It costs a comparison a pair, which
  /// belongs to no stage: measurements leave it out.
  bool count_adjacent = true;
  /// The mesh is the solid mesh of a ShellThickener: contacts of features that stem from one vertex of the shell mesh
  /// (share_shell_vertex) are no contacts. All stages see their tests as any others.
  bool leave_out_shell_neighbours = false;

  Request() = default;
  Request(Query q, bool overlaps = false, bool without_shell_neighbours = false)  // NOLINT: a Query is a request
      : query(q), initial_overlaps(overlaps), leave_out_shell_neighbours(without_shell_neighbours) {}
};

struct StepResult {
  /// In canonical order, each feature pair once. The same bit for bit for any number of workers.
  std::vector<Contact> contacts;
  /// Those that Request::leave_out_shell_neighbours keeps from being in `contacts`, in the same order. Empty for a
  /// query for the first contact, which does not find them all.
  std::vector<Contact> left_out;
  /// If asked for: all pairs of non-adjacent elements, a < b, ascending, that step.filter allows and whose convex hulls
  /// have a point in common at t = 0, one inside the other included (with a separation: come as close as that). Exact,
  /// and the same for every pipeline whose broad phase is conservative (docs/initial_overlaps.md).
  std::vector<ElementPair> initial_overlaps;
  Statistics statistics;
};

/// Immutable once made; run() may be called from several threads with different workspaces.
class Pipeline {
 public:
  /// Throws ConfigError: unknown stage or option, or a combination whose completeness argument does not hold, with the
  /// reason.
  Pipeline(const Registry& registry, const PipelineSpec& spec);

  /// With every option of its stages, defaults included.
  const PipelineSpec& spec() const { return spec_; }
  /// The weakest of the stages'.
  Guarantee guarantee() const { return guarantee_; }

  Workspace make_workspace() const;

  /// Runs one step. Throws ConfigError if a stage does not handle the step's degree of motion or separation, if shell
  /// neighbours are to be left out of a mesh that has not three vertices for each of a shell mesh, if the workspace was
  /// not made by this pipeline, or if a thread's floating-point environment is not the standard one
  /// (core/floating_point.hpp); InputError if motion and mesh differ in their number of vertices. After any exception
  /// the workspace is as good as a new one, and the result is unspecified. Once the workspace has grown to the scene, a
  /// step on an unchanged topology allocates nothing but what the result's vectors need, and what tests need that exact
  /// arithmetic decides.
  void run(const Step& step, Workspace& workspace, Executor& executor, StepResult& result,
           const Request& request = {}) const;

 private:
  class Run;

  void check(const Step& step) const;
  void make_states(Workspace::Data& data) const;

  PipelineSpec spec_;
  std::uint64_t id_;  ///< by which workspaces are known
  Guarantee guarantee_ = Guarantee::exact;
  std::unique_ptr<BroadPhase> broad_phase_;
  std::vector<std::unique_ptr<ElementCulling>> element_culling_;
  std::unique_ptr<Assignment> assignment_;
  std::unique_ptr<OrphanSource> orphans_;  ///< may be null
  std::unique_ptr<Flood> flood_;           ///< may be null
  std::vector<std::unique_ptr<FeatureFilter>> feature_filters_;
  std::unique_ptr<NarrowPhase> narrow_phase_;
  std::vector<const Stage*> stages_;  ///< all of them, in the order of spec_.stages()
  PairRange range_ = PairRange::every;
  /// For messages: which narrow phases handle three control points, and a separation.
  std::string curved_narrow_phases_, separating_narrow_phases_;
};

}  // namespace volccd
