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

/// What a Detector is made with, beside its mesh.
struct RunnerConfig {
  std::string pipeline;
  std::vector<std::string> settings;
  unsigned threads = 0;
  double separation = 0;
  std::string pairs;  ///< all, inter, intra
  std::vector<std::pair<std::int32_t, std::int32_t>> exclude;

  /// From keyword arguments with these names, all of them present.
  explicit RunnerConfig(const py::dict& options);
};

/// What a step is asked for.
struct StepRequest {
  bool first = false, initial_overlaps = false;
  double t_max = 1;
};

class Runner {
 public:
  /// Throws ConfigError. The registry may change afterwards.
  explicit Runner(const RunnerConfig& config);

  /// Called without the GIL; throws what Pipeline::run throws, and what a signal handler or a stage in Python raises.
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

/// Facts about a runner for Python: pipeline, guarantee, threads, stages.
py::dict runner_facts(Runner& runner);

}  // namespace volccd::python
