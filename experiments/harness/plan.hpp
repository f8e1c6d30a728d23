// An experiment as data: which pipelines run on which steps of which sequences, how often, and how rows name them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd {

/// A pipeline of an experiment, with its names in the rows.
struct Entrant {
  std::string table;     ///< "a", "b", "c" if the experiment has several tables; may be empty
  std::string pipeline;  ///< as rows name it, e.g. "VolCCD"
  std::string variant;   ///< settings beside the preset's, "csat.axis=face"; may be empty
  PipelineSpec spec;
  bool on_boundary = false;  ///< runs on the boundary alone, as triangle shells (harness/boundary_shells.hpp)
  bool without_separation = false;  ///< runs with separation 0 where a query has one, so that contacts differ
};

/// The consecutive steps [first, first + count).
struct StepWindow {
  int first = 0, count = 1;
};

/// One sequence with its configuration, and the pipelines that run on it.
struct SceneRun {
  std::string scene;  ///< as rows name it
  std::string file;
  SequenceStepper::Config config = {};
  std::vector<StepWindow> windows = {};
  std::vector<Entrant> entrants = {};
  int rounds = 0;           ///< 0: those of the plan
  unsigned threads = 0;     ///< 0: those of the executor that the experiment runs with
  double motion_scale = 1;  ///< control points are x0 + motion_scale (x - x0)
  /// How many times each element is divided (harness/subdivide.hpp); solid shells are divided in their plane. For
  /// scenes without edits: after an edit, the divided mesh is built from scratch.
  int subdivisions = 0;
  nlohmann::json columns = nlohmann::json::object();  ///< further columns of all rows
};

struct ExperimentPlan {
  std::string name;
  std::string setting;  ///< "quick" or "full"
  int rounds = 1;
  std::vector<SceneRun> runs;
  int processes = 1;         ///< that the rounds are divided among; at most `rounds`
  std::string options = {};  ///< what a caller has changed, as on the command line: "--scenes run.vtkhdf --rounds 5"
};

/// `count` windows of `length` steps each, spread evenly over [1, steps). Step 0 is left out because no step
/// precedes it that could prepare the state. If these windows would contain all steps, there is one window with all
/// steps.
std::vector<StepWindow> sampled_windows(int steps, int count, int length);

/// The same windows, but if none of them contains one of the `edits` (steps at which the cells change), the window that
/// is closest to an edit is moved to it. No window is moved if it would overlap with another one.
std::vector<StepWindow> with_an_edit(std::vector<StepWindow> windows, int steps, const std::vector<int>& edits);

/// All steps, in windows of `length` (the last may be shorter).
std::vector<StepWindow> all_windows(int steps, int length);

int rounds_of(const ExperimentPlan& plan, const SceneRun& run);

/// The rounds [first, second) that a process measures, in order of the processes.
std::pair<int, int> rounds_of_process(const ExperimentPlan& plan, const SceneRun& run, int process);

/// Number of measurements: the sum over runs and windows of rounds x entrants x steps.
std::size_t measured_runs(const ExperimentPlan& plan);

/// The parts of the plan on which rows depend (file names without folders). A record can be resumed if these are equal.
nlohmann::json to_json(const ExperimentPlan& plan);

}  // namespace volccd
