// A pipeline with everything that it needs to run steps, except for the mesh and the motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include <volccd/core/executor.hpp>
#include <volccd/pipelines/lists/candidate_list.hpp>
#include <volccd/pipelines/lists/detail/motion_sample.hpp>
#include <volccd/pipelines/lists/list_policy.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// How a StepRunner runs its pipeline.
struct RunConfig {
  /// Number of threads; 0: as many as the hardware has. Not used if there is an executor.
  unsigned threads = 1;
  /// Runs the steps, and must outlive the StepRunner; null: an executor of its own, from make_executor(threads).
  Executor* executor = nullptr;
  /// Distance at which features are in contact, in the unit of the coordinates; finite, >= 0. 0: when they touch.
  double separation = 0;
  /// The pairs of objects whose contacts are found; default: all, including contacts within an object.
  ObjectFilter filter = {};
  /// The meshes are solid meshes of thickened shells, and contacts of shell neighbours are not found
  /// (Step::leave_out_shell_neighbours).
  bool leave_out_shell_neighbours = false;
  /// Whether steps test lists of candidates of earlier steps. Contacts are those of fresh steps
  /// (docs/candidate_lists.md).
  ListConfig lists = {};
};

/// Runs a pipeline on the steps of topologies that belong to the caller, such as those of a SequenceStepper; Detector
/// runs it on a mesh of its own. Owns the workspace, and with it the tables that stages keep from step to step: they
/// follow the edits of a topology, and are rebuilt for another one. Movable; one thread at a time.
class StepRunner {
 public:
  /// Throws ConfigError for an invalid separation, number of threads or budget, and for lists with a pipeline that is
  /// neither exact nor conservative.
  explicit StepRunner(Pipeline pipeline, RunConfig config = {});

  /// Runs a step: `motion` has the control points of all vertices of the topology. Contacts later than t_max, in 0 .. 1
  /// of the step, need not be found. `piece`: that of Step. Returns result(). Throws ConfigError for
  /// another t_max, and the exceptions of Pipeline::run. After any exception result() is unspecified and the next step
  /// runs as with a new StepRunner.
  const StepResult& run(const Topology& topology, const Motion& motion, const Request& request = {}, double t_max = 1,
                        const Piece& piece = {});

  /// The result of the last step; valid until the next one.
  const StepResult& result() const { return result_; }
  /// Moves the result of the last step out; result() is empty afterwards.
  StepResult release_result();

  const Pipeline& pipeline() const { return pipeline_; }
  Executor& executor() const { return *executor_; }
  const ObjectFilter& filter() const { return filter_; }
  double separation() const { return separation_; }
  /// Throws ConfigError if the value is negative or not finite.
  void set_separation(double separation);
  /// Memory that the pipeline keeps from step to step, without the result.
  std::size_t workspace_bytes() const { return workspace_.bytes() + list_.bytes() + sample_.bytes(); }

 private:
  void compare_motion(const Step& step, double& list_seconds);
  bool reuse_list(const Step& step, const Request& request, double& list_seconds);
  bool make_list(const Step& step, const Request& request, double& list_seconds);
  void run_tests(const Step& step, Request request, double list_seconds);

  Pipeline pipeline_;
  Workspace workspace_;
  std::unique_ptr<Executor> own_executor_;  ///< null if the caller gave one
  Executor* executor_;
  ObjectFilter filter_;
  bool leave_out_shell_neighbours_;
  double separation_ = 0;
  StepResult result_;
  ListConfig lists_;
  CandidateList list_;
  ListPolicy policy_;
  detail::MotionSample sample_;
  ListPolicy::Motion moved_{};  ///< of this step, with automatic lists
  int refreshed_ = 0;           ///< how often the list had been refreshed before this step
  double distance_ = 0;         ///< the largest distance of a step that the list covered from its prediction
};

}  // namespace volccd
