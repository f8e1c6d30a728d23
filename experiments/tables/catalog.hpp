// The experiments that the harness runs: each a plan, tables and a summary from its record.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/harness/plan.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// What a plan is made for.
struct PlanContext {
  const Registry& registry;
  bool full = false;
  std::vector<std::string> pipelines;  ///< further ones, or those of an ablation
  std::vector<std::string> settings;   ///< "stage.option=value[,value...]" or "role=stage[,stage...]"
  /// The sequence file of a scene's name, or nothing if it is not there. May take long (a bake), and may throw.
  std::function<std::optional<std::string>(const std::string& name)> file_of;
  /// For `rows`: what they are measured with (null: one thread), and who is told how far it is; may throw to stop.
  Executor* executor = nullptr;
  std::function<void(std::size_t done, std::size_t total)> progress = {};
};

struct ExperimentKind {
  const char *name, *description;
  ExperimentPlan (*plan)(const PlanContext& context);  ///< null where `rows` makes them
  std::vector<TitledTable> (*tables)(const nlohmann::json& record);
  /// Rows for scripts and other documents; may be null: none.
  nlohmann::json (*summary)(const nlohmann::json& record);
  /// Rows that the harness does not make; may be null.
  std::vector<nlohmann::json> (*rows)(const PlanContext& context) = nullptr;
  bool takes_pipelines = false, takes_settings = false;  ///< of the context
};

const std::vector<ExperimentKind>& experiment_kinds();

/// The five simulated scenes and, behind them, the runs of other programs that are there.
struct TableScene {
  std::string name;  ///< as rows have it
  std::string file;
};
std::vector<TableScene> table_scenes(const PlanContext& context);

/// How a scene's elements are taken in the tables: shells as solids where the file has their thickness.
SequenceStepper::Config table_config(const std::string& file, MotionModel motion = MotionModel::linear);
int motion_count(const std::string& file);

/// A registered pipeline with settings; `variant` lists them.
Entrant entrant(const Registry& registry, const std::string& table, const std::string& pipeline,
                const std::vector<std::string>& settings = {});

std::string ratio_text(double value);
std::string percent_text(double share);

}  // namespace volccd
