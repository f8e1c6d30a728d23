// An experiment as data: which pipelines run on which motions of which sequences, how often, and what rows say of it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd {

/// A pipeline that takes part, and what its rows are known by.
struct Entrant {
  std::string table;     ///< "a", "b", "c" where an experiment has several tables; may be empty
  std::string pipeline;  ///< as rows name it, e.g. "VolCCD"
  std::string variant;   ///< settings beside the preset's, "csat.axis=face"; may be empty
  PipelineSpec spec;
  bool on_boundary = false;  ///< runs on the boundary alone, as triangle shells (harness/boundary_shells.hpp)
};

/// Motions [first, first + count) that follow each other.
struct MotionWindow {
  int first = 0, count = 1;
};

/// One sequence under one treatment.
struct SceneRun {
  std::string scene;  ///< as rows name it
  std::string file;
  SequenceStepper::Config config = {};
  std::vector<MotionWindow> windows;
  std::vector<Entrant> entrants;
  int rounds = 0;           ///< 0: those of the plan
  unsigned threads = 0;     ///< 0: those of the executor that the experiment runs with
  double motion_scale = 1;  ///< control points are x0 + motion_scale (x - x0)
  /// Times that each element is divided (harness/subdivide.hpp), solid shells in their plane. For scenes without edits:
  /// an edit builds the divided mesh anew.
  int subdivisions = 0;
  nlohmann::json columns = nlohmann::json::object();  ///< further columns of all rows
};

struct ExperimentPlan {
  std::string name;
  std::string setting;  ///< "quick" or "full"
  int rounds = 1;
  std::vector<SceneRun> runs;
};

/// As the command line has them.
const char* name_of(MotionModel model);
const char* name_of(ShellModel model);
const char* name_of(EdgeSet set);

/// `count` windows of `length` motions each, spread evenly over [1, motions): motion 0 has none before it that could
/// bring a state up to it. All motions, in one window, where that is no more.
std::vector<MotionWindow> sampled_windows(int motions, int count, int length);

/// All motions, in windows of `length` (the last may be shorter).
std::vector<MotionWindow> all_windows(int motions, int length);

int rounds_of(const ExperimentPlan& plan, const SceneRun& run);

/// Motions that are measured: runs x windows x rounds x entrants x motions.
std::size_t measured_runs(const ExperimentPlan& plan);

/// The plan as far as the rows depend on it (file names without folders): what a record is resumed by.
nlohmann::json to_json(const ExperimentPlan& plan);

}  // namespace volccd
