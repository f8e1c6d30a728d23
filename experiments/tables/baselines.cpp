#include <volccd/experiments/tables/baselines.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <volccd/experiments/tables/interval.hpp>
#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// The column `table` of the entrants, of a caller's pipelines, and of the small scenes with several seeds.
constexpr const char *kTable = "d", *kOwn = "own", *kSeedTable = "seeds";
constexpr int kSeeds = 3;
constexpr const char* kFilters = "feature-filter=feature-kdop,coplanarity";

/// An entrant, with its names in rows and tables.
struct TableEntrant {
  std::string pipeline, variant, title, preset;
  std::vector<std::string> settings = {};
  bool baseline = true;
  std::string broad_phase = {};  ///< of another library, which the program may be without
};

const std::vector<TableEntrant>& names() {
  static const std::vector<TableEntrant> all = {
      {"NavCCD", "", "NavCCD", "NavCCD"},
      {"NavCCD", "no adjacent", "no adjacent", "NavCCD", {"orphans=o-set"}},
      {"NavCCD", "no adjacent, filters", "with filters", "NavCCD", {"orphans=o-set", kFilters}},
      {"NavCCD",
       "no adjacent, filters, Embree",
       "Embree",
       "NavCCD",
       {"broad-phase=embree-collide", "orphans=o-set", kFilters},
       true,
       "embree-collide"},
      {"NavCCD",
       "no adjacent, filters, CGAL",
       "CGAL",
       "NavCCD",
       {"broad-phase=cgal-box-intersection", "orphans=o-set", kFilters},
       true,
       "cgal-box-intersection"},
      {"VolCCD+", "no theorem", "no theorem", "VolCCD+", {"flood=none", "orphans=o-set"}},
      {"VolCCD", "", "VolCCD", "VolCCD", {}, false},
      {"VolCCD+", "stars alone", "stars alone", "VolCCD+", {"flood=none"}, false},
      {"VolCCD+", "flood alone", "flood alone", "VolCCD+", {"orphans=o-set"}, false},
      {"VolCCD+", "", "VolCCD+", "VolCCD+", {}, false}};
  return all;
}

const TableEntrant& named(const char* title) {
  return *std::find_if(names().begin(), names().end(), [&](const TableEntrant& name) { return name.title == title; });
}

bool is_there(const Registry& registry, const TableEntrant& name) {
  if (name.broad_phase.empty()) return true;
  const auto& stages = registry.stages<BroadPhase>();
  return std::any_of(stages.begin(), stages.end(), [&](const auto& stage) { return stage.name == name.broad_phase; });
}

/// The rows of one scene.
struct BaselineRows {
  std::string scene;
  Rows rows;

  Rows of(const TableEntrant& n) const { return rows.with("pipeline", n.pipeline).with("variant", n.variant); }
  Rows of(const char* title) const { return of(named(title)); }
  double ms(const TableEntrant& n) const {
    const Rows some = of(n);
    return some.empty() ? 0 : some.mean_ms(kStepAndEditTime);
  }
  /// How many times faster `fast` is.
  RatioInterval speedup(const TableEntrant& slow, const TableEntrant& fast) const {
    return ratio_of_times(of(slow), of(fast), kStepAndEditTime);
  }
  const TableEntrant& strongest() const {
    const TableEntrant* best = nullptr;
    for (const TableEntrant& name : names())
      if (name.baseline && ms(name) > 0 && (!best || ms(name) < ms(*best))) best = &name;
    return *best;
  }
  /// The steps in which something touches, or those in which nothing does.
  BaselineRows with_contacts(bool some) const {
    std::vector<json> steps;
    for (const json& step : rows.values("step"))
      if ((of("VolCCD+").with("step", step).sum("contacts") > 0) == some) steps.push_back(step);
    return {scene, rows.with_any("step", steps)};
  }
};

std::vector<BaselineRows> scenes_of(const Rows& rows, const std::vector<json>& tables = {kTable, kOwn}) {
  std::vector<BaselineRows> scenes;
  for (const Rows& some : rows.with_any("table", tables).groups({"scene"}))
    scenes.push_back({some.value("scene"), some});
  return scenes;
}

/// The entrants of the rows: those of names() that are there, then a caller's pipelines.
std::vector<TableEntrant> table_entrants(const Rows& rows) {
  std::vector<TableEntrant> entrants;
  for (const TableEntrant& name : names())
    if (!rows.with("pipeline", name.pipeline).with("variant", name.variant).empty()) entrants.push_back(name);
  for (const json& pipeline : rows.with("table", kOwn).values("pipeline"))
    entrants.push_back({pipeline, "", pipeline, pipeline, {}, false});
  return entrants;
}

TitledTable times(const std::vector<BaselineRows>& scenes, const std::vector<TableEntrant>& entrants) {
  std::vector<std::string> header = {"scene", "elements", "steps"};
  for (const TableEntrant& name : entrants) header.push_back(name.title);
  TextTable table(header);
  for (const BaselineRows& scene : scenes) {
    std::vector<std::string> line = {scene.scene, grouped(static_cast<std::uint64_t>(scene.rows.median("elements"))),
                                     std::to_string(scene.rows.steps())};
    for (const TableEntrant& name : entrants) line.push_back(number_text(scene.ms(name)));
    table.add(line);
  }
  return {"Table I-d: the strongest baselines, ms a step", table,
          "mean over steps of medians over rounds, edits of the topology included; no adjacent: NavCCD on non-adjacent "
          "pairs, with an O-Set; with filters, Embree, CGAL: the same with feature-kdop and coplanarity, and with "
          "these libraries' broad phases; no theorem, stars alone, flood alone: VolCCD+ with these of its two "
          "theorems\n"};
}

TitledTable ratios(const std::vector<BaselineRows>& scenes) {
  TextTable table({"scene", "strongest", "VolCCD+ over it", "VolCCD over it", "VolCCD+ over NavCCD"});
  for (const BaselineRows& scene : scenes) {
    const TableEntrant& best = scene.strongest();
    table.add({scene.scene, best.title, interval_text(scene.speedup(best, named("VolCCD+"))),
               interval_text(scene.speedup(best, named("VolCCD"))),
               interval_text(scene.speedup(named("NavCCD"), named("VolCCD+")))});
  }
  return {"Speed-up over the strongest baseline", table,
          "the baseline that is fastest on the scene; in brackets: the 95 % interval over steps and rounds\n"};
}

TitledTable theorems(const std::vector<BaselineRows>& scenes) {
  TextTable table({"scene", "no theorem, ms", "stars", "flood", "both"});
  for (const BaselineRows& scene : scenes) {
    const TableEntrant& none = named("no theorem");
    std::vector<std::string> line = {scene.scene, number_text(scene.ms(none))};
    for (const char* title : {"stars alone", "flood alone", "VolCCD+"})
      line.push_back(interval_text(scene.speedup(none, named(title))));
    table.add(line);
  }
  return {"What each theorem gives: speed-up over VolCCD+ with neither", table,
          "stars: star-orphans in place of the O-Set; flood: boundary-flood\n"};
}

/// Empty without small scenes.
std::vector<TitledTable> seeds(const std::vector<BaselineRows>& scenes) {
  TextTable table({"scene", "elements", "strongest", "VolCCD+ over it", "VolCCD+ over NavCCD"});
  for (const BaselineRows& scene : scenes) {
    const TableEntrant& best = scene.strongest();
    table.add({scene.scene, grouped(static_cast<std::uint64_t>(scene.rows.median("elements"))), best.title,
               interval_text(scene.speedup(best, named("VolCCD+"))),
               interval_text(scene.speedup(named("NavCCD"), named("VolCCD+")))});
  }
  if (scenes.empty()) return {};
  return {
      {"Several seeds, small scenes", table,
       "a seed changes positions, directions or speeds at the start; strongest: of NavCCD, the same without adjacent "
       "pairs and with filters, and VolCCD+ without its theorems\n"}};
}

TitledTable by_contacts(const std::vector<BaselineRows>& scenes) {
  TextTable table({"scene", "steps with contacts", "VolCCD+, ms", "speed-up", "steps without", "VolCCD+, ms there",
                   "speed-up there"});
  for (const BaselineRows& scene : scenes) {
    std::vector<std::string> line = {scene.scene};
    for (const bool some : {true, false}) {
      const BaselineRows part = scene.with_contacts(some);
      line.push_back(std::to_string(part.rows.empty() ? 0 : part.rows.steps()));
      line.push_back(part.rows.empty() ? "-" : number_text(part.ms(named("VolCCD+"))));
      line.push_back(part.rows.empty() ? "-" : interval_text(part.speedup(scene.strongest(), named("VolCCD+"))));
    }
    table.add(line);
  }
  return {"Steps with contacts, and without", table, "speed-up: of VolCCD+ over the scene's strongest baseline\n"};
}

TitledTable first_steps(const std::vector<BaselineRows>& scenes, const std::vector<TableEntrant>& entrants) {
  std::vector<std::string> header = {"scene"};
  for (const TableEntrant& name : entrants) header.push_back(name.title);
  TextTable table(header);
  for (const BaselineRows& scene : scenes) {
    std::vector<std::string> line = {scene.scene};
    for (const TableEntrant& name : entrants) {
      const Rows of = scene.of(name);
      line.push_back(of.empty() ? "-" : number_text(1e3 * of.front().at("first_seconds").get<double>()));
    }
    table.add(line);
  }
  return {"Cold start: the first step of each, ms", table, "not in the means above\n"};
}

/// Which entrants run on the small scenes.
bool varies_with_seed(const TableEntrant& name) {
  constexpr std::array kTitles = {"NavCCD", "with filters", "no theorem", "VolCCD+"};
  return std::find(kTitles.begin(), kTitles.end(), name.title) != kTitles.end();
}

/// The simulated scenes at their small size, with each seed.
std::vector<TableScene> scenes_with_seeds(const PlanContext& context) {
  std::vector<TableScene> found;
  for (const std::string name : {"octopi", "bullet", "airbag", "liver", "crash"})
    for (int seed = 1; seed <= kSeeds && context.full && context.own_scenes.empty(); ++seed) {
      const std::string scene = fmt::format("{}-quick-seed-{}", name, seed);
      if (const std::optional<std::string> file = context.file_of(scene)) found.push_back({scene, *file});
    }
  return found;
}

SceneRun run_of(const PlanContext& context, const TableScene& scene, const char* table,
                bool (*takes)(const TableEntrant&)) {
  SceneRun run{scene.name, scene.file, table_config(scene.file), table_windows(context, scene.file), {}};
  for (const TableEntrant& name : names()) {
    if (!is_there(context.registry, name) || !takes(name)) continue;
    run.entrants.push_back(entrant(context.registry, table, name.preset, name.settings));
    run.entrants.back().variant = name.variant;
  }
  return run;
}

}  // namespace

ExperimentPlan baselines_plan(const PlanContext& context) {
  ExperimentPlan plan{"baselines", context.full ? "full" : "quick", context.full ? kFullRounds : 1, {}};
  if (context.full) plan.processes = kFullProcesses;
  for (const TableScene& scene : table_scenes(context)) {
    plan.runs.push_back(run_of(context, scene, kTable, [](const TableEntrant&) { return true; }));
    for (const std::string& pipeline : context.pipelines)
      plan.runs.back().entrants.push_back(entrant(context.registry, kOwn, pipeline));
  }
  for (const TableScene& scene : scenes_with_seeds(context))
    plan.runs.push_back(run_of(context, scene, kSeedTable, varies_with_seed));
  return plan;
}

std::vector<TitledTable> baselines_tables(const json& record) {
  const Rows rows(record);
  const std::vector<BaselineRows> scenes = scenes_of(rows);
  const std::vector<TableEntrant> entrants = table_entrants(rows);
  std::vector<TitledTable> tables = {ratios(scenes), times(scenes, entrants), theorems(scenes), by_contacts(scenes),
                                     first_steps(scenes, entrants)};
  for (TitledTable& table : seeds(scenes_of(rows, {kSeedTable}))) tables.push_back(std::move(table));
  return tables;
}

json baselines_summary(const json& record) {
  json summary = json::array();
  for (const BaselineRows& scene : scenes_of(Rows(record))) {
    const TableEntrant &best = scene.strongest(), &plus = named("VolCCD+");
    json line = {{"scene", scene.scene},
                 {"elements", scene.rows.median("elements")},
                 {"steps", scene.rows.steps()},
                 {"strongest", best.title},
                 {"strongest_ms", scene.ms(best)},
                 {"volccd_ms", scene.ms(named("VolCCD"))},
                 {"volccd_plus_ms", scene.ms(plus)}};
    const auto add = [&](const std::string& key, const TableEntrant& slow, const TableEntrant& fast) {
      const RatioInterval ratio = scene.speedup(slow, fast);
      line[key] = ratio.value;
      line[key + "_interval"] = {ratio.low, ratio.high};
    };
    add("speedup_strongest_plus", best, plus);
    add("speedup_strongest", best, named("VolCCD"));
    add("speedup_navccd_plus", named("NavCCD"), plus);
    add("gain_stars", named("no theorem"), named("stars alone"));
    add("gain_flood", named("no theorem"), named("flood alone"));
    add("gain_both", named("no theorem"), plus);
    summary.push_back(line);
  }
  return summary;
}

}  // namespace volccd
