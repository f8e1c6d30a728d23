#include <volccd/experiments/tables/plus.hpp>

#include <thread>

#include <fmt/format.h>

#include <volccd/experiments/tables/interval.hpp>
#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// An entrant, with its names in rows and in tables.
struct Name {
  const char *pipeline, *title;
  const char* preset = "VolCCD+";
  const char* flood = "boundary-flood";  ///< null: the flood of the preset
  bool on_boundary = false;
};
constexpr const char* kVariant = "inclusion";  ///< of these, not of a caller's pipelines
constexpr Name kVolCCD = {"VolCCD", "VolCCD", "VolCCD", nullptr};
constexpr Name kWithoutFlood = {"VolCCD+ without flood", "without flood", "VolCCD+", "none"};
constexpr Name kPlus = {"VolCCD+", "VolCCD+"};
constexpr Name kBoundary = {"boundary alone", "boundary", "VolCCD+", "boundary-flood", true};
constexpr Name kPlainBoundary = {"boundary alone without flood", "boundary, no flood", "VolCCD+", "none", true};
constexpr Name kEntrants[] = {kVolCCD, kWithoutFlood, kPlus, kBoundary, kPlainBoundary};

Entrant plus_entrant(const PlanContext& context, const std::string& table, const Name& name) {
  std::vector<std::string> settings;
  if (name.flood) settings.push_back(std::string("flood=") + name.flood);
  Entrant result = entrant(context.registry, table, name.preset, settings);
  result.pipeline = name.pipeline;
  result.variant = kVariant;
  result.on_boundary = name.on_boundary;
  return result;
}

/// One scene on one number of threads.
struct Group {
  json scene;
  Rows rows;

  Rows of(const Name& name) const { return rows.with("pipeline", name.pipeline).with("variant", kVariant); }
  double ms(const Name& name) const {
    const Rows some = of(name);
    return some.empty() ? 0 : some.mean_ms(kStepAndEditTime);
  }
  RatioInterval ratio(const Name& a, const Name& b) const { return ratio_of_times(of(a), of(b), kStepAndEditTime); }
  double contacts(const Name& name) const {
    const Rows some = of(name);
    return some.empty() ? 0 : some.sum("contacts");
  }
  unsigned threads() const { return rows.front().at("threads"); }
};

std::vector<Group> groups_of(const Rows& rows) {
  std::vector<Group> groups;
  for (const Rows& some : rows.groups({"table", "scene"})) groups.push_back({some.value("scene"), some});
  return groups;
}

std::string text_ms(double value) { return value > 0 ? number_text(value) : "-"; }
std::string text_ratio(double value) { return value > 0 ? ratio_text(value) : "-"; }
std::string whole_number(double value) { return grouped(static_cast<std::uint64_t>(value)); }

TitledTable times(const std::vector<Group>& groups) {
  std::vector<std::string> header = {"scene", "threads", "elements", "on boundary", "steps"};
  for (const Name& name : kEntrants) header.push_back(name.title);
  TextTable table(header, 3);
  for (const Group& group : groups) {
    std::vector<std::string> row = {
        group.scene, std::to_string(group.threads()), whole_number(group.of(kPlus).median("elements")),
        whole_number(group.of(kBoundary).median("elements")), std::to_string(group.rows.steps())};
    for (const Name& name : kEntrants) row.push_back(text_ms(group.ms(name)));
    table.add(row);
  }
  return {"Whole steps, ms", table,
          "mean over steps of medians over rounds, edits of the topology included; on boundary: triangles there; "
          "boundary: contacts of boundary features only\n"};
}

TitledTable ratios(const std::vector<Group>& groups) {
  TextTable table({"scene", "threads", "VolCCD / VolCCD+", "flood gains", "volume / surface"}, 3);
  for (const Group& group : groups)
    table.add({group.scene, std::to_string(group.threads()), interval_text(group.ratio(kVolCCD, kPlus)),
               interval_text(group.ratio(kWithoutFlood, kPlus)), interval_text(group.ratio(kPlus, kBoundary))});
  return {"Ratios of these times", table,
          "in brackets: 95 % intervals over steps and rounds; flood gains: without over with; volume / surface: "
          "VolCCD+ over the boundary alone, same stages\n"};
}

TitledTable counts(const std::vector<Group>& groups) {
  TextTable table({"scene", "pipeline", "pairs", "survive", "owned tests", "orphans", "VF + EE tests", "contacts"}, 3);
  for (const Group& group : groups) {
    if (group.threads() != groups.front().threads()) continue;  // the same for any number of threads
    for (const Name& name : kEntrants) {
      const Rows of = group.of(name);
      if (of.empty()) continue;
      const double steps = static_cast<double>(of.steps());
      std::vector<std::string> row = {group.scene, name.title};
      for (const char* column : {"element_pairs", "surviving_pairs", "owned_tests", "orphan_tests"})
        row.push_back(whole_number(of.sum(column) / steps));
      row.push_back(whole_number(of.tests() / steps));
      row.push_back(whole_number(of.sum("contacts") / steps));
      table.add(row);
    }
  }
  return {"Counts of a step", table,
          "means over the same steps; pairs: of elements, that the broad phase or the flood gave; orphans: "
          "tests of the O-Set\n"};
}

/// The time on one thread divided by that on several threads; 0 if the record has no row on one thread.
double speedup_of_threads(const std::vector<Group>& groups, const Group& group, const Name& name) {
  for (const Group& one : groups)
    if (one.threads() == 1 && group.threads() > 1 && one.scene == group.scene)
      return group.ms(name) > 0 ? one.ms(name) / group.ms(name) : 0;
  return 0;
}

void add_threads_table(const std::vector<Group>& groups, std::vector<TitledTable>& tables) {
  std::vector<std::string> header = {"scene", "threads"};
  for (const Name& name : kEntrants) header.push_back(name.title);
  TextTable table(header, 3);
  bool any = false;
  for (const Group& group : groups) {
    if (speedup_of_threads(groups, group, kPlus) <= 0) continue;
    any = true;
    std::vector<std::string> row = {group.scene, std::to_string(group.threads())};
    for (const Name& name : kEntrants) row.push_back(text_ratio(speedup_of_threads(groups, group, name)));
    table.add(row);
  }
  if (any) tables.push_back({"Speed-up of threads", table, "time on one thread over time on several\n"});
}

}  // namespace

ExperimentPlan plus_plan(const PlanContext& context) {
  ExperimentPlan plan{"plus", context.full ? "full" : "quick", context.full ? kFullRounds : 3, {}};
  if (context.full) plan.processes = kFullProcesses;
  const bool two_cores = context.full && std::thread::hardware_concurrency() >= 2;
  for (const TableScene& scene : table_and_large_scenes(context)) {
    const bool shortened = !context.full && scene.large;
    for (const unsigned threads : {0u, 2u}) {
      if (threads > 0 && !two_cores) continue;
      const std::string table = threads > 0 ? fmt::format("{} threads", threads) : "";
      SceneRun run{
          scene.name,
          scene.file,
          table_config(scene.file),
          context.full ? table_windows(context, scene.file) : sampled_windows(scene.file, 1, shortened ? 1 : 2),
          {}};
      run.threads = threads;
      if (shortened) run.rounds = 1;
      for (const Name& name : kEntrants) run.entrants.push_back(plus_entrant(context, table, name));
      for (const std::string& pipeline : context.pipelines)
        run.entrants.push_back(entrant(context.registry, table, pipeline));
      plan.runs.push_back(std::move(run));
    }
  }
  return plan;
}

std::vector<TitledTable> plus_tables(const json& record) {
  const std::vector<Group> groups = groups_of(Rows(record));
  std::vector<TitledTable> tables = {times(groups), ratios(groups), counts(groups)};
  add_threads_table(groups, tables);
  return tables;
}

json plus_summary(const json& record) {
  const std::vector<Group> groups = groups_of(Rows(record));
  json summary = json::array();
  for (const Group& group : groups) {
    summary.push_back({{"scene", group.scene},
                       {"threads", group.threads()},
                       {"elements", group.of(kPlus).median("elements")},
                       {"steps", group.rows.steps()},
                       {"volccd_ms", group.ms(kVolCCD)},
                       {"volccd_plus_ms", group.ms(kPlus)},
                       {"without_flood_ms", group.ms(kWithoutFlood)},
                       {"boundary_only_ms", group.ms(kBoundary)},
                       {"boundary_without_flood_ms", group.ms(kPlainBoundary)},
                       {"speedup_volccd", group.ratio(kVolCCD, kPlus).value},
                       {"volume_over_surface", group.ratio(kPlus, kBoundary).value},
                       {"flood_gain", group.ratio(kWithoutFlood, kPlus).value},
                       {"contacts", group.contacts(kPlus)},
                       {"boundary_contacts", group.contacts(kBoundary)}});
    if (const double speedup = speedup_of_threads(groups, group, kPlus); speedup > 0)
      summary.back()["speedup_threads"] = speedup;
  }
  return summary;
}

}  // namespace volccd
