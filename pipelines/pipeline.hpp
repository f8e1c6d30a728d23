// A pipeline: broad phase, element culling, assignment, orphan source, flood, feature filters, narrow phase.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>
#include <volccd/pipelines/stage_observer.hpp>
#include <volccd/pipelines/statistics.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/work_source.hpp>

namespace volccd {

/// All memory that a pipeline keeps from step to step. A workspace is used by one run at a time, and only with the
/// pipeline that created it (Pipeline::make_workspace). A default-constructed workspace cannot be used until another
/// one is moved into it.
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
  first  ///< only the earliest contact (for equal times, the first in canonical order); later contacts are pruned
};

/// Options of a run.
struct Request {
  Query query = Query::all;
  bool initial_overlaps = false;  ///< fill StepResult::initial_overlaps with all of them; also with Query::first
  /// Fill Statistics::adjacent_pairs if the broad phase emits adjacent pairs. This costs one comparison per pair, which
  /// belongs to no stage; measurements should disable it.
  bool count_adjacent = true;
  /// Fill StepResult::ends.
  bool ends = false;
  /// The tests to perform, in place of those that the stages find: a list that contains all that can be in contact
  /// (CandidateList). Only the feature filters and the narrow phase run, the latter first for what it finds at the
  /// start (NarrowPhase::find_at_start), filtered or not; there are no initial overlaps.
  const TestBatch* tests = nullptr;
  /// Receives the tests that the feature filters keep, but for those that leave tests to others, ascending, each once,
  /// in place of being performed by the narrow phase; the step has no contacts then.
  TestBatch* candidates = nullptr;
  /// Receives the pairs between the stages; may be null, and then costs one comparison per batch. Must outlive the run.
  StageObserver* observer = nullptr;
};

struct StepResult {
  /// In canonical order, each feature pair once. The same bit for bit for any number of workers.
  std::vector<Contact> contacts;
  /// If requested: the features of each contact, in the same order, at the end of the step.
  std::vector<ContactEnd> ends;
  /// If requested: all pairs of non-adjacent elements, a < b, ascending, that step.filter allows and whose convex hulls
  /// have a common point at t = 0, including one element inside the other (with a separation d > 0: whose distance is
  /// at most d). Exact, and the same for every pipeline with a conservative broad phase (docs/initial_overlaps.md).
  std::vector<ElementPair> initial_overlaps;
  Statistics statistics;
};

/// Immutable after construction. Several threads may call run() concurrently with different workspaces.
class Pipeline {
 public:
  /// Throws ConfigError, with the reason, for an unknown stage or option, and for a combination whose completeness
  /// argument does not hold.
  Pipeline(const Registry& registry, const PipelineSpec& spec);

  /// The specification with every option of its stages, including defaults.
  const PipelineSpec& spec() const { return spec_; }
  /// The weakest guarantee among the stages.
  Guarantee guarantee() const { return guarantee_; }
  /// Whether a stage reads Piece::cut_stars.
  bool uses_cut_stars() const;

  Workspace make_workspace() const;

  /// Runs one step. Throws ConfigError if a stage does not support the step's degree of motion or its separation, if
  /// shell neighbours are to be left out but the mesh does not have three vertices for each vertex of a shell mesh, if
  /// the workspace was not created by this pipeline, or if the floating-point environment of a thread is not the
  /// standard one (core/floating_point.hpp). Throws InputError if motion and mesh have different numbers of vertices.
  /// After any exception the workspace is equivalent to a new one, and the result is unspecified. Once the workspace
  /// has grown to the size of the scene, a step on an unchanged topology allocates memory only for the vectors of the
  /// result, for tests that exact arithmetic decides, and where outer parts of a flood change.
  void run(const Step& step, Workspace& workspace, Executor& executor, StepResult& result,
           const Request& request = {}) const;

 private:
  class Run;

  void check(const Step& step) const;
  void check(const Step& step, const Workspace& workspace) const;
  void make_states(Workspace::Data& data) const;

  PipelineSpec spec_;
  std::uint64_t id_;  ///< identifies the pipeline in its workspaces
  Guarantee guarantee_ = Guarantee::exact;
  std::unique_ptr<BroadPhase> broad_phase_;
  std::vector<std::unique_ptr<ElementCulling>> element_culling_;
  std::unique_ptr<Assignment> assignment_;
  std::unique_ptr<OrphanSource> orphans_;  ///< may be null
  std::unique_ptr<Flood> flood_;           ///< may be null
  std::vector<std::unique_ptr<FeatureFilter>> feature_filters_;
  std::unique_ptr<NarrowPhase> narrow_phase_;
  std::vector<const Stage*> stages_;  ///< all stages, in the order of spec_.stages()
  PairRange range_ = PairRange::every;
  /// For messages: the narrow phases that support three control points, and those that support a separation.
  std::string curved_narrow_phases_, separating_narrow_phases_;
};

}  // namespace volccd
