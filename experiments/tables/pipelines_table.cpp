#include <volccd/experiments/tables/pipelines_table.hpp>

#include <cmath>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

std::string label(const json& row) {
  const std::string variant = row.at("variant");
  return row.at("pipeline").get<std::string>() + (variant.empty() ? "" : " " + variant);
}

/// "3 + 0.99329": the first step with a contact, and its time within it.
std::string earliest(const Rows& rows) {
  for (const json& step : rows.values("step"))
    if (const json toi = rows.with("step", step).front().at("earliest_toi"); toi.is_number())
      return fmt::format("{} + {:.5f}", step.get<int>(), toi.get<double>());
  return "-";
}

bool same_contacts(const Rows& rows, const Rows& reference) {
  for (const json& step : rows.values("step"))
    if (rows.with("step", step).values("contacts_hash") !=
        reference.with("step", step).with("round", 0).values("contacts_hash"))
      return false;
  return true;
}

std::string count(double value) { return grouped(static_cast<std::uint64_t>(value)); }

TitledTable comparison(const Rows& rows, const std::string& scene) {
  const std::vector<Rows> entrants = rows.groups({"pipeline", "variant"});
  const Rows &nav = rows.with("pipeline", "NavCCD"), &hash = rows.with("pipeline", "HashCCD");
  const auto over = [](const Rows& baseline, const Rows& of) {
    return baseline.empty() ? std::string("-")
                            : ratio_text(baseline.mean_ms(kStepAndEditTime) / of.mean_ms(kStepAndEditTime));
  };
  TextTable table({"pipeline", "time/step", "/NavCCD", "/HashCCD", "element pairs", "VF tests", "EE tests", "tests",
                   "contacts", "earliest", "same"});
  for (const Rows& of : entrants)
    table.add({label(of.front()), duration(of.mean_ms(kStepAndEditTime) / 1e3), over(nav, of), over(hash, of),
               count(of.sum("element_pairs")), count(of.sum("vf_tests")), count(of.sum("ee_tests")),
               nav.empty() ? "-" : percent_text(of.tests() / nav.tests()), count(of.sum("contacts")), earliest(of),
               same_contacts(of, entrants[0]) ? "yes" : "NO"});
  table.rule();
  table.add({"paper, bullet", "48 ms", "21x", "28x", "-", "-", "-", "0.69 %", "-", "-", "-"});
  return {
      fmt::format("{}: {}, {}, {}", scene, counted(rows.steps(), "step"), counted(rows.values("round").size(), "round"),
                  counted(rows.front().at("threads").get<std::uint64_t>(), "thread")),
      table,
      "time: mean over steps of medians over rounds, edits of the topology included; counts: sums over steps; /: "
      "speed-up; tests: share of NavCCD's; earliest: step + time; same: the first pipeline's contacts, bit for bit\n"};
}

TitledTable stage_shares(const Rows& rows, const std::string& scene) {
  const std::pair<const char*, const char*> roles[] = {
      {"broad_phase", "broad phase"}, {"element_culling", "element culling"}, {"assignment", "assignment"},
      {"orphans", "O-Set"},           {"feature_filter", "filters"},          {"narrow_phase", "tests"}};
  std::vector<std::string> header = {"share of time, %", "prepare"};
  for (const auto& [role, title] : roles) header.push_back(title);
  header.push_back("rest");
  TextTable table(header);
  for (const Rows& of : rows.groups({"pipeline", "variant"})) {
    const double whole = std::max(of.sum("seconds") * of.front().at("threads").get<double>(), 1e-300);
    double prepare = 0, known = 0;
    std::vector<std::string> cells;
    for (const auto& [role, title] : roles) {
      const double run = of.sum(std::string(role) + "_run_s");
      prepare += of.sum(std::string(role) + "_prepare_s");
      known += run;
      cells.push_back(run > 0 ? fixed_text(100 * run / whole, 1) : "-");
    }
    cells.insert(cells.begin(), {label(of.front()), fixed_text(100 * prepare / whole, 1)});
    cells.push_back(fixed_text(100 * (whole - prepare - known) / whole, 1));
    table.add(cells);
  }
  return {scene + ": where the time goes", table, ""};
}

std::vector<TableScene> projectile_scenes(const PlanContext& context) {
  if (!context.own_scenes.empty()) return context.own_scenes;
  for (const char* name : {"ls-dyna-projectile", "builtin"})
    if (const std::optional<std::string> file = context.file_of(name)) return {{name, *file}};
  throw ConfigError("projectile: there is neither ls-dyna-projectile nor the scene builtin");
}

}  // namespace

ExperimentPlan projectile_plan(const PlanContext& context) {
  std::vector<std::string> pipelines = {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"};
  pipelines.insert(pipelines.end(), context.pipelines.begin(), context.pipelines.end());
  ExperimentPlan plan{"projectile", context.full ? "full" : "quick", context.full ? kFullRounds : 1, {}};
  for (const TableScene& scene : projectile_scenes(context)) {
    SceneRun run{scene.name, scene.file, {}, all_windows(step_count(scene.file), 5), {}};
    if (!context.own_scenes.empty()) run.config = table_config(scene.file);
    for (const std::string& pipeline : pipelines) {
      run.entrants.push_back(entrant(context.registry, "", pipeline, {"narrow-phase=cubic"}));
      run.entrants.back().variant.clear();  // the same for all
    }
    plan.runs.push_back(std::move(run));
  }
  return plan;
}

std::vector<TitledTable> pipeline_tables(const json& record) {
  const Rows rows(record);
  std::vector<TitledTable> tables;
  for (const Rows& of : rows.groups({"scene"})) {
    const std::string scene = of.value("scene");
    tables.push_back(comparison(of, scene));
    tables.push_back(stage_shares(of, scene));
  }
  return tables;
}

}  // namespace volccd
