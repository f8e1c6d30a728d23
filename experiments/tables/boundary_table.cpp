#include <volccd/experiments/tables/boundary_table.hpp>

#include <fmt/format.h>

#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

constexpr const char* kCompared[] = {"VolCCD-2011", "VolCCD", "VolCCD+"};
/// The paper's ratio, "-" where it has none: for the bullet of Figure 3 (a) and (b), 3.2 "with a single thread",
/// and 1.3 "with the help of SIMD instructions and multi-threads". VolCCD-2011 is scalar; the others use SIMD.
const char* printed(const json& scene, const std::string& pipeline, unsigned threads) {
  if (scene != "bullet") return "-";
  const bool scalar = pipeline == "VolCCD-2011";
  if (scalar && threads == 1) return "3.2x";
  return !scalar && threads > 1 ? "1.3x" : "-";
}

/// The rows of one pipeline on one scene and number of threads.
Rows rows_of(const Rows& rows, const json& scene, const json& threads, const std::string& pipeline, const char* mesh) {
  return rows.with("scene", scene).with("threads", threads).with("pipeline", pipeline).with("mesh", mesh);
}

double ms_of(const Rows& rows) { return rows.empty() ? 0 : rows.mean_ms(kStepAndEditTime); }
std::string ms_text(double ms) { return ms > 0 ? number_text(ms) : "-"; }
std::string ratio_of(double a, double b) { return a > 0 && b > 0 ? ratio_text(a / b) : "-"; }

/// Whole and boundary on the same steps.
TitledTable same_motions(const Rows& rows) {
  TextTable table({"scene", "threads", "pipeline", "steps", "elements", "on boundary", "all, ms", "boundary, ms",
                   "all / boundary", "paper", "contacts, all", "contacts, boundary"},
                  3);
  for (const json& scene : rows.values("scene")) {
    table.rule();
    for (const json& threads : rows.values("threads"))
      for (const std::string pipeline : kCompared) {
        const Rows whole = rows_of(rows, scene, threads, pipeline, "whole");
        const Rows boundary = rows_of(rows, scene, threads, pipeline, "boundary");
        if (whole.empty() || boundary.empty()) continue;
        const auto count = [](const Rows& of, const char* column) {
          return grouped(static_cast<std::uint64_t>(of.sum(column)));
        };
        table.add({scene, std::to_string(threads.get<unsigned>()), pipeline, std::to_string(whole.steps()),
                   grouped(static_cast<std::uint64_t>(whole.median("elements"))),
                   grouped(static_cast<std::uint64_t>(boundary.median("elements"))), ms_text(ms_of(whole)),
                   ms_text(ms_of(boundary)), ratio_of(ms_of(whole), ms_of(boundary)),
                   printed(scene, pipeline, threads.get<unsigned>()), count(whole, "contacts"),
                   count(boundary, "contacts")});
      }
  }
  return {
      "Section 7.1: all features against the boundary's, on the same steps", table,
      "ms: mean over steps of medians over rounds, edits of the topology included; on boundary: triangles there; "
      "the paper's: scalar on one thread, and with SIMD on four cores; VolCCD-2011 is scalar, the others use SIMD\n"};
}

/// Compares all features, on the simulation with all features, with the boundary, on the simulations with fewer
/// features: cases (a) and (b) of Figure 3.
std::optional<TitledTable> two_simulations(const Rows& rows) {
  TextTable table({"boundary of", "threads", "pipeline", "bullet, all features, ms", "boundary, ms", "ratio", "paper"},
                  3);
  bool any = false;
  for (const char* other : {"bullet-boundary", "bullet-surface"})
    for (const json& threads : rows.values("threads"))
      for (const std::string pipeline : kCompared) {
        const double a = ms_of(rows_of(rows, "bullet", threads, pipeline, "whole"));
        const double b = ms_of(rows_of(rows, other, threads, pipeline, "boundary"));
        if (a <= 0 || b <= 0) continue;
        any = true;
        table.add({other, std::to_string(threads.get<unsigned>()), pipeline, ms_text(a), ms_text(b), ratio_of(a, b),
                   printed("bullet", pipeline, threads.get<unsigned>())});
      }
  if (!any) return std::nullopt;
  return TitledTable{"Section 7.1: the same on two simulations, Figure 3 (a) and (b)", table,
                     "all features on the bullet that is simulated with contacts among all features, over the boundary "
                     "on the bullet that is simulated with contacts among those of the boundary, or of the first "
                     "surface; the two were not measured in turns\n"};
}

std::vector<TableScene> boundary_scenes(const PlanContext& context) {
  if (!context.own_scenes.empty()) return context.own_scenes;
  std::vector<TableScene> scenes;
  for (const std::string name : {"octopi", "bullet", "bullet-boundary", "bullet-surface", "airbag", "liver", "crash"})
    if (const std::optional<std::string> file = context.file_of(name + (context.full ? "" : "-quick")))
      scenes.push_back({name, *file});
  return scenes;
}

}  // namespace

ExperimentPlan boundary_plan(const PlanContext& context) {
  ExperimentPlan plan{"boundary", context.full ? "full" : "quick", context.full ? kFullRounds : 3, {}};
  for (const TableScene& scene : boundary_scenes(context)) {
    for (const unsigned threads : {1u, 2u}) {
      SceneRun run{scene.name, scene.file, table_config(scene.file),
                   sampled_windows(step_count(scene.file), context.full ? 4 : 1, context.full ? 2 : 3)};
      run.threads = threads;
      for (const char* pipeline : kCompared)
        for (const bool on_boundary : {false, true}) {
          run.entrants.push_back(entrant(context.registry, on_boundary ? "boundary" : "all features", pipeline));
          run.entrants.back().on_boundary = on_boundary;
        }
      plan.runs.push_back(std::move(run));
    }
  }
  return plan;
}

std::vector<TitledTable> boundary_tables(const json& record) {
  const Rows rows(record);
  std::vector<TitledTable> tables = {same_motions(rows)};
  if (std::optional<TitledTable> other = two_simulations(rows)) tables.push_back(std::move(*other));
  return tables;
}

}  // namespace volccd
