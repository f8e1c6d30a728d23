// Runs one step through a standard pipeline.
#pragma once

#include <string>

#include <volccd/pipelines/pipeline.hpp>

namespace volccd::test {

inline const ObjectFilter kAllObjects;

/// The result of the pipeline with a new workspace, on the calling thread.
inline StepResult run_step(const Step& step, const Request& request = {}, const std::string& name = "VolCCD+") {
  const Registry registry = Registry::standard();
  const Pipeline pipeline(registry, registry.pipeline(name));
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor executor;
  StepResult result;
  pipeline.run(step, workspace, executor, result, request);
  return result;
}

}  // namespace volccd::test
