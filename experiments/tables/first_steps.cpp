#include <volccd/experiments/tables/first_steps.hpp>

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/pipelines/stage_clock.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

using nlohmann::json;

namespace {

constexpr int kFirstStepRounds = 5;
/// The motion of the first step is in the middle of the sequence, where there are contacts; the later ones follow it,
/// and the last one is repeated if there are not enough.
constexpr int kLaterSteps = 4;
constexpr const char* kFirstStepParts[] = {"topology_s", "tree_s", "tables_s", "rest_s"};

/// Prepare times of the broad phase and of all other stages.
std::pair<double, double> prepare_seconds(const Statistics& statistics) {
  double tree = 0, tables = 0;
  for (const StageStatistics& stage : statistics.stages)
    (stage.role == "broad-phase" ? tree : tables) += stage.prepare_seconds;
  return {tree, tables};
}

/// The parts of the first step of a new topology, with an empty workspace.
json first_step(const SequenceStepper& stepper, StepRunner& runner, const Request& request, Executor& executor) {
  double topology_seconds = 0;
  StageClock clock;
  Mesh mesh = stepper.topology().mesh();
  std::optional<Topology> topology;
  {
    const StageTimer timer(clock, topology_seconds);
    topology.emplace(std::move(mesh), executor);
  }
  const Statistics& statistics = runner.run(*topology, stepper.motion(), request).statistics;
  const auto [tree, tables] = prepare_seconds(statistics);
  return {{"topology_s", topology_seconds},
          {"tree_s", tree},
          {"tables_s", tables},
          {"rest_s", statistics.seconds - tree - tables},
          {"first_s", topology_seconds + statistics.seconds},
          {"workspace_bytes", runner.workspace_bytes()},
          {"elements", topology->mesh().element_count()}};
}

json measure(const PlanContext& context, const TableScene& scene, Executor& executor) {
  SequenceReader reader(scene.file);
  const SequenceStepper::Config config = table_config(scene.file);
  SequenceStepper stepper(reader, config);
  const Request request{.count_adjacent = false};
  const auto runner = [&] {
    return StepRunner(Pipeline(context.registry, context.registry.pipeline("VolCCD+")),
                      {.executor = &executor, .leave_out_shell_neighbours = config.shells == ShellModel::solid});
  };
  const int first = std::max(0, stepper.step_count() / 2 - kLaterSteps);
  stepper.go_to(first, executor);
  StepRunner of_first = runner(), of_all = runner();
  json row = first_step(stepper, of_first, request, executor);
  of_all.run(stepper.topology(), stepper.motion(), request);
  std::vector<double> later;
  for (int k = first + 1; k <= first + kLaterSteps; ++k) {
    stepper.go_to(std::min(k, stepper.step_count() - 1), executor);
    later.push_back(of_all.run(stepper.topology(), stepper.motion(), request).statistics.seconds);
  }
  row["later_s"] = median(later);
  row["step"] = first;
  return row;
}

/// One scene.
struct SceneRows {
  json scene;
  Rows rows;

  double ms(const char* column) const { return rows.mean_ms({column}); }
  double ratio() const { return ms("first_s") / ms("later_s"); }
  double bytes_per_element() const { return rows.median("workspace_bytes") / rows.median("elements"); }
};

std::vector<SceneRows> by_scene(const Rows& rows) {
  std::vector<SceneRows> groups;
  for (const Rows& some : rows.groups({"scene"})) groups.push_back({some.value("scene"), some});
  return groups;
}

}  // namespace

ExperimentPlan first_steps_plan(const PlanContext& context) {
  ExperimentPlan plan{"first-steps", context.full ? "full" : "quick", kFirstStepRounds, {}};
  for (const TableScene& scene : table_and_large_scenes(context)) plan.runs.push_back({scene.name, scene.file});
  return plan;
}

void first_steps_rows(const PlanContext& context, RecordFile& record) {
  const std::vector<TableScene> scenes = table_and_large_scenes(context);
  if (scenes.empty()) throw ConfigError("first-steps: none of its scenes is available");
  Executor& executor = context.executor ? *context.executor : serial_executor();
  for (int round = 0; round < kFirstStepRounds; ++round)
    for (std::size_t s = 0; s < scenes.size(); ++s) {
      const std::string part = fmt::format("{}, round {}", scenes[s].name, round);
      if (record.has(part)) continue;
      if (context.progress)
        context.progress(static_cast<std::size_t>(round) * scenes.size() + s, kFirstStepRounds * scenes.size());
      json row = measure(context, scenes[s], executor);
      row.update({{"scene", scenes[s].name}, {"round", round}, {"threads", executor.workers()}});
      record.add(part, {std::move(row)});
    }
}

std::vector<TitledTable> first_steps_tables(const json& record) {
  TextTable table({"scene", "elements", "topology, ms", "tree, ms", "tables, ms", "rest, ms", "first, ms", "later, ms",
                   "first / later", "bytes an element"});
  for (const SceneRows& group : by_scene(Rows(record))) {
    std::vector<std::string> row = {group.scene.get<std::string>(),
                                    grouped(static_cast<std::uint64_t>(group.rows.median("elements")))};
    for (const char* part : kFirstStepParts) row.push_back(fmt::format("{:.3g}", group.ms(part)));
    row.push_back(fmt::format("{:.3g}", group.ms("first_s")));
    row.push_back(fmt::format("{:.3g}", group.ms("later_s")));
    row.push_back(ratio_text(group.ratio()));
    row.push_back(fmt::format("{:.0f}", group.bytes_per_element()));
    table.add(std::move(row));
  }
  return {{"First steps of VolCCD+", table,
           "topology: of a mesh that is given; tree: prepare() of the broad phase; tables: prepare() of all other "
           "stages; rest: of the step; first: the sum of these; later: a step afterwards without edits; medians over "
           "rounds; bytes: of the workspace after the first step, without the topology\n"}};
}

json first_steps_summary(const json& record) {
  json summary = json::array();
  for (const SceneRows& group : by_scene(Rows(record)))
    summary.push_back({{"scene", group.scene},
                       {"elements", group.rows.median("elements")},
                       {"threads", group.rows.front().at("threads")},
                       {"topology_ms", group.ms("topology_s")},
                       {"tree_ms", group.ms("tree_s")},
                       {"tables_ms", group.ms("tables_s")},
                       {"rest_ms", group.ms("rest_s")},
                       {"first_ms", group.ms("first_s")},
                       {"later_ms", group.ms("later_s")},
                       {"ratio", group.ratio()},
                       {"bytes_per_element", group.bytes_per_element()}});
  return summary;
}

}  // namespace volccd
