#include <volccd/experiments/tables/ablation.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/tables/coplanarity_table.hpp>
#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// The tests that no pair of elements owns, or all pairs with all their tests.
struct Orphans {
  const char* name;
  std::vector<std::string> settings;
};

/// Adds VolCCD+ with some of its stages on one broad phase. The flood needs assignment, and CSAT: without CSAT, it
/// continues through all pairs of the broad phase.
void add_subsets_of(const Registry& registry, const char* broad_phase, const Orphans& orphans,
                    std::vector<Entrant>& entrants) {
  for (const bool flood : {false, true})
    for (const bool filters : {false, true})
      for (const bool csat : {false, true}) {
        if (flood && (!csat || *orphans.name == '\0')) continue;
        std::vector<std::string> settings = {std::string("broad-phase=") + broad_phase}, names;
        settings.insert(settings.end(), orphans.settings.begin(), orphans.settings.end());
        csat ? names.emplace_back("CSAT") : settings.emplace_back("element-culling=none");
        if (*orphans.name != '\0') names.emplace_back(orphans.name);
        filters ? names.emplace_back("filters") : settings.emplace_back("feature-filter=none");
        flood ? names.emplace_back("flood") : settings.emplace_back("flood=none");
        Entrant one = entrant(registry, "stages", "VolCCD+", settings);
        one.pipeline = broad_phase;
        one.variant = names.empty() ? "none" : fmt::format("{}", fmt::join(names, " + "));
        entrants.push_back(std::move(one));
      }
}

void add_subsets(const Registry& registry, std::vector<Entrant>& entrants) {
  const Orphans kinds[] = {{"", {"orphans=none", "assignment=all-pairs"}},
                           {"assignment + O-Set", {"orphans=o-set"}},
                           {"assignment + star orphans", {"orphans=star-orphans"}}};
  for (const char* broad_phase : {"kdop-bvh", "spatial-hash", "brute-force"})
    for (const Orphans& orphans : kinds) add_subsets_of(registry, broad_phase, orphans, entrants);
}

struct Sweep {
  const char *pipeline, *key, *values;
};
constexpr Sweep kOptions[] = {{"VolCCD", "csat.axis", "face,predetermined,velocity,centroid,optimal"},
                              {"VolCCD+", "csat.mode", "pair,features,both"},
                              {"VolCCD+", "kdop-bvh.k", "6,14,16,18,24,26"},
                              {"VolCCD+", "kdop-bvh.leaf_size", "1,2,4,8"},
                              {"VolCCD+", "kdop-bvh.adjacent_pairs", "table,vertices"},
                              {"VolCCD+", "kdop-bvh.restructure", "none,subtrees,always"},
                              {"HashCCD", "spatial-hash.cell_size", "0.5,1,2,4"},
                              {"VolCCD", "o-set.kind", "minimal,literal"},
                              {"VolCCD", "feature-csat.axes", "first,ends,wide"},
                              {"VolCCD+", "feature-kdop.bounds", "swept,relative"}};

std::vector<std::string> split(const std::string& values) {
  std::vector<std::string> parts(1);
  for (const char c : values) c == ',' ? parts.emplace_back() : parts.back() += c;
  return parts;
}

void add_sweep(const Registry& registry, const std::string& table, const std::string& pipeline, const std::string& key,
               const std::string& values, std::vector<Entrant>& entrants) {
  for (const std::string& value : split(values))
    entrants.push_back(entrant(registry, table, pipeline, {key + "=" + value}));
}

void add_options(const Registry& registry, std::vector<Entrant>& entrants) {
  for (const Sweep& sweep : kOptions) add_sweep(registry, "options", sweep.pipeline, sweep.key, sweep.values, entrants);
  for (const char* filters :
       {"none", "feature-csat", "coplanarity", "feature-kdop", "feature-kdop,coplanarity,feature-csat"})
    entrants.push_back(entrant(registry, "options", "VolCCD", {std::string("feature-filter=") + filters}));
  // Static assignment tests every feature pair without an O-Set (docs/pipelines.md).
  entrants.push_back(
      entrant(registry, "options", "VolCCD+", {"flood=none", "orphans=none", "assignment=static-assignment"}));
  for (const char* orphans : {"orphans=o-set", "orphans=star-orphans"}) {
    entrants.push_back(entrant(registry, "options", "VolCCD+", {orphans}));
    entrants.push_back(entrant(registry, "options", "VolCCD+", {"flood=none", orphans}));
  }
  entrants.push_back(entrant(registry, "options", "VolCCD+"));
}

void add_own(const PlanContext& context, std::vector<Entrant>& entrants) {
  std::vector<std::string> pipelines = context.pipelines;
  if (pipelines.empty()) pipelines = {"VolCCD+"};
  for (const std::string& pipeline : pipelines) {
    entrants.push_back(entrant(context.registry, "sweep", pipeline));
    for (const std::string& setting : context.settings) {
      const std::size_t equals = setting.find('=');
      if (equals == std::string::npos)
        throw ConfigError(fmt::format("--set {}: is not stage.option=value[,value...]", setting));
      // The values of a role form one list; those of an option are tried one by one.
      if (setting.find('.') > equals)
        entrants.push_back(entrant(context.registry, "sweep", pipeline, {setting}));
      else
        add_sweep(context.registry, "sweep", pipeline, setting.substr(0, equals), setting.substr(equals + 1), entrants);
    }
  }
}

TitledTable table_of(const Rows& rows, const std::string& title) {
  TextTable table({"pipeline", "settings", "ms a step", "relative", "pairs", "survive", "tests", "contacts"}, 2);
  double best = 0;
  const std::vector<Rows> entrants = rows.groups({"pipeline", "variant"});
  for (const Rows& of : entrants) {
    const double ms = of.mean_ms(kStepAndEditTime);
    best = best > 0 ? std::min(best, ms) : ms;
  }
  for (const Rows& of : entrants) {
    const auto count = [&](const char* column) { return grouped(static_cast<std::uint64_t>(of.sum(column))); };
    const std::string variant = of.value("variant");
    table.add({of.value("pipeline"), variant.empty() ? "-" : variant, number_text(of.mean_ms(kStepAndEditTime)),
               number_text(of.mean_ms(kStepAndEditTime) / best), count("element_pairs"), count("surviving_pairs"),
               grouped(static_cast<std::uint64_t>(of.tests())), count("contacts")});
  }
  return {
      title, table,
      "ms: mean over steps of medians over rounds, edits of the topology included; relative: to the fastest; counts: "
      "sums over steps\n"};
}

}  // namespace

ExperimentPlan ablation_plan(const PlanContext& context) {
  ExperimentPlan plan{"ablation", context.full ? "full" : "quick", context.full ? kFullRounds : 1, {}};
  const bool own = !context.pipelines.empty() || !context.settings.empty();
  for (const TableScene& scene : table_scenes(context)) {
    // Without the crash, which takes longest and whose results are similar to those of the other scenes.
    if (context.own_scenes.empty() && scene.name != "octopi" && scene.name != "bullet" &&
        scene.name != "ls-dyna-projectile" && !(own && scene.name == "crash"))
      continue;
    SceneRun run{scene.name,
                 scene.file,
                 table_config(scene.file),
                 context.full ? sampled_windows(scene.file, 2, 2) : sampled_windows(scene.file, 1, 1),
                 {}};
    SceneRun coplanarity = run;
    if (own) {
      add_own(context, run.entrants);
      plan.runs.push_back(std::move(run));
      continue;
    }
    add_subsets(context.registry, run.entrants);
    add_options(context.registry, run.entrants);
    plan.runs.push_back(std::move(run));
    coplanarity.rounds = 5;  // its ratios are of stages that may take less than a millisecond
    add_coplanarity(context.registry, coplanarity.entrants);
    plan.runs.push_back(std::move(coplanarity));
  }
  return plan;
}

std::vector<TitledTable> ablation_tables(const json& record) {
  const Rows rows(record);
  std::vector<TitledTable> tables;
  for (const Rows& of : rows.groups({"scene", "table"})) {
    const std::string table = of.value("table");
    const bool coplanarity = table == kCoplanarityTable;
    const std::string title = fmt::format("{}: {}, {} elements, {} steps", of.value("scene").get<std::string>(),
                                          coplanarity ? "coplanarity against CSAT (Section 7.2)" : table,
                                          grouped(static_cast<std::uint64_t>(of.median("elements"))), of.steps());
    tables.push_back(coplanarity ? coplanarity_table(of, title) : table_of(of, title));
  }
  return tables;
}

}  // namespace volccd
