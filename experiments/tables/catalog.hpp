// The experiments that the harness runs. Each has a plan, and makes tables and a summary from its record.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/harness/plan.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// Of full runs: rounds of all experiments that measure times, processes of those whose ratios have intervals.
inline constexpr int kFullRounds = 5, kFullProcesses = 2;

struct TableScene {
  std::string name;  ///< as in rows
  std::string file;
  bool large = false;  ///< a quick run has fewer steps of it
};

/// Input of the functions that make plans.
struct PlanContext {
  const Registry& registry;
  bool full = false;
  std::vector<std::string> pipelines;  ///< further pipelines, or those of an ablation
  std::vector<std::string> settings;   ///< "stage.option=value[,value...]" or "role=stage[,stage...]"
  /// Returns the sequence file of a scene, or nothing if it is not available. May take long (it may run a simulation),
  /// and may throw.
  std::function<std::optional<std::string>(const std::string& name)> file_of;
  /// For `rows`: the executor (null: one thread), and a function that is told the progress; it may throw to stop.
  Executor* executor = nullptr;
  std::function<void(std::size_t done, std::size_t total)> progress = {};
  /// A caller's own sequences, in the place of the experiment's scenes (ExperimentKind::takes_scenes).
  std::vector<TableScene> own_scenes = {};
};

struct ExperimentKind {
  const char *name, *description;
  /// Makes the plan. If `rows` makes the rows, the plan has the inputs only (runs without windows).
  ExperimentPlan (*plan)(const PlanContext& context);
  std::vector<TitledTable> (*tables)(const nlohmann::json& record);
  /// Makes the summary for scripts and other documents; null: there is none.
  nlohmann::json (*summary)(const nlohmann::json& record) = nullptr;
  /// Makes the rows, if the harness does not make them from a plan, and adds them part by part, but for the parts that
  /// the record has; may be null.
  void (*rows)(const PlanContext& context, RecordFile& record) = nullptr;
  bool takes_pipelines = false, takes_settings = false;  ///< whether it uses those of the context
  bool takes_scenes = false;  ///< whether PlanContext::own_scenes can take the place of its scenes
  bool curves = false;        ///< one row for each scene and step: the report draws its numbers over the steps
};

const std::vector<ExperimentKind>& experiment_kinds();

/// A caller's own scenes; else the five simulated scenes, followed by those runs of other programs that are available.
std::vector<TableScene> table_scenes(const PlanContext& context);
/// A caller's own scenes; else these, followed by large ones that are available: a mesh of 105 K tetrahedra that is
/// turned and shortened, and two surfaces.
std::vector<TableScene> table_and_large_scenes(const PlanContext& context);

/// Configuration of a scene in the tables: shells are solid if the file has their thickness.
SequenceStepper::Config table_config(const std::string& file, MotionModel motion = MotionModel::linear);
int step_count(const std::string& file);
/// sampled_windows() of a file, of which at least one contains an edit if one can (with_an_edit()).
std::vector<StepWindow> sampled_windows(const std::string& file, int count, int length);
/// The sample of the tables whose ratios are published: 12 motions of a full run, in four windows; one of a quick run.
std::vector<StepWindow> table_windows(const PlanContext& context, const std::string& file);

/// A registered pipeline with settings; `variant` lists them.
Entrant entrant(const Registry& registry, const std::string& table, const std::string& pipeline,
                const std::vector<std::string>& settings = {});

std::string ratio_text(double value);
std::string percent_text(double share);

}  // namespace volccd
