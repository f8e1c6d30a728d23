// Pipelines side by side on one sequence: the measurement behind the paper's Table I, as a record and as text.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <nlohmann/json.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/core/step_text.hpp>
#include <volccd/mesh/sequence/stepper.hpp>

#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// One pipeline on all steps.
struct PipelineRecord {
  std::string name;
  nlohmann::json configuration;  ///< stages, options, guarantee
  /// [step]: statistics of the round with the median time (its counts are the same in every round).
  std::vector<Statistics> steps;
  /// Contacts of all steps are the same as those of the first pipeline, bit for bit.
  bool same_contacts = true;

  Statistics total() const;
  /// Seconds a step, median over steps.
  double median_seconds() const;
};

struct ComparisonRecord {
  std::string sequence;
  int rounds = 0;
  unsigned threads = 1;
  std::vector<PipelineRecord> pipelines;
  /// Which steps have been compared, and why no more.
  StepsDone compared = {};

  nlohmann::json to_json() const;  ///< with machine_facts()
};

struct ComparisonConfig {
  std::string sequence;  ///< its name, for the record
  std::vector<std::string> pipelines = {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"};
  int rounds = 1;
  /// Called before each run of a pipeline; may throw to stop.
  std::function<void(std::size_t done, std::size_t total)> progress;
};

/// For each motion, all pipelines in turn, `rounds` times (interleaved, so that a drifting machine hits all alike);
/// every pipeline keeps its workspace from step to step. The first step is run once more beforehand, not counted
/// (warm-up). `record` holds the steps that are complete, also when this throws: record.compared.stopped_by is left to
/// the caller.
void compare_pipelines(const Registry& registry, SequenceStepper& stepper, const ComparisonConfig& config,
                       Executor& executor, ComparisonRecord& record);

/// Time a step, speed-up, element pairs, tests, culling ratio (tests in per cent of NavCCD's), contacts, earliest time; the
/// paper's printed row for the bullet beside it.
std::string comparison_table(const ComparisonRecord& record);
/// Per cent of the time in each stage; the remainder is what no stage accounts for.
std::string share_table(const ComparisonRecord& record);

}  // namespace volccd
