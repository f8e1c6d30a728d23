// A pipeline with its workspace, executor and filter, that runs steps without the GIL.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "result.hpp"

namespace volccd::python {

/// The arguments of a Detector except for its mesh.
struct RunnerConfig {
  std::string pipeline;
  std::vector<std::string> settings;
  unsigned threads = 0;
  double separation = 0;
  std::string pairs;  ///< all, inter, intra
  std::vector<std::pair<std::int32_t, std::int32_t>> exclude;

  /// Reads keyword arguments with these names, all of which must be present.
  explicit RunnerConfig(const py::dict& options);
};

/// The options of a step.
struct StepRequest {
  bool first = false, initial_overlaps = false;
  double t_max = 1;
};

class Runner {
 public:
  /// Throws ConfigError. The registry may change afterwards.
  explicit Runner(const RunnerConfig& config);

  /// Must be called without the GIL. Throws the exceptions of Pipeline::run, and those of a signal handler or of a
  /// stage in Python.
  std::shared_ptr<Result> run(const Topology& topology, const Motion& motion, const StepRequest& request,
                              bool shell_neighbours_left_out);

  const Pipeline& pipeline() const { return pipeline_; }
  Executor& executor() { return *executor_; }
  double separation() const { return separation_; }
  void set_separation(double separation);

 private:
  Pipeline pipeline_;
  Workspace workspace_;
  std::unique_ptr<Executor> executor_;
  ObjectFilter filter_;
  double separation_ = 0;
};

/// Properties of a runner for Python: pipeline, guarantee, threads, stages.
py::dict runner_facts(Runner& runner);

}  // namespace volccd::python
