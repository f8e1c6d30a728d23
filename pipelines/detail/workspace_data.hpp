// The contents of a Workspace.
#pragma once

#include <memory>
#include <vector>

#include <volccd/pipelines/detail/result.hpp>
#include <volccd/pipelines/detail/worker_scratch.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

struct Workspace::Data {
  std::uint64_t pipeline = 0;  ///< id of the pipeline that created the workspace
  bool intact = false;         ///< false during a run, and after a run that threw; then the states are recreated
  std::vector<std::unique_ptr<StageState>> states;  ///< in the order of the stages
  std::vector<std::unique_ptr<detail::WorkerScratch>> workers;
  detail::ResultMerger merger;
};

}  // namespace volccd
