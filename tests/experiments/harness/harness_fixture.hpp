// A small sequence, and the pipelines of table c that run on it.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/experiments/harness/run.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/tables/catalog.hpp>

#include "support/all_stages.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {

/// The built-in scene of a block that passes through a plate; elements are removed on the way.
class Harness : public testing::Test {
 protected:
  Harness() : file_(folder_ / "builtin.vtkhdf") {
    write_scene(*make_scene("builtin", {{"elements", "200"}, {"frames", "9"}}), file_);
  }

  ExperimentPlan plan(int rounds, std::vector<StepWindow> windows) const {
    SceneRun run{"block", file_, {}, std::move(windows), {}};
    for (const char* pipeline : {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"})
      run.entrants.push_back(entrant(registry_, "c", pipeline));
    return {"test", "quick", rounds, {run}};
  }
  std::vector<nlohmann::json> rows_of(const ExperimentPlan& plan, unsigned threads, const std::string& name) {
    const auto executor = make_thread_executor(threads);
    RecordFile record(folder_ / "", name, {{"name", name}});
    run_experiment(registry_, plan, *executor, record);
    return record.rows();
  }

  const ScratchFolder folder_;
  const std::string file_;
  const Registry registry_ = test::all_stages();
};

}  // namespace volccd::test
