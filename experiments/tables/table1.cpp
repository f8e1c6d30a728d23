#include <volccd/experiments/tables/table1.hpp>

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include <volccd/experiments/tables/interval.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/reader.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Table I as printed.
struct PaperRow {
  const char *time, *over_nav, *over_hash, *ratio;
};
const std::map<std::string, PaperRow> kPrintedRows = {{"octopi", {"75 ms", "12x", "18.3x", "0.01 %"}},
                                                      {"bullet", {"48 ms", "21x", "28x", "0.69 %"}},
                                                      {"airbag", {"88 ms", "10.2x", "13x", "0.58 %"}},
                                                      {"liver", {"53 ms", "10.3x", "14.1x", "0.72 %"}},
                                                      {"crash", {"3.3 s", "12.4x", "17.4x", "3.54 %"}}};

/// NavCCD without adjacent pairs; the O-Set has the tests that only these contain.
constexpr const char* kNoAdjacent = "orphans=o-set";
/// NavCCD with the filters that gain most. The paper's has none.
constexpr const char* kFiltered = "feature-filter=feature-kdop,coplanarity";
/// VolCCD+ in query motions, asked without their separation.
constexpr const char* kWithoutSeparation = "without separation";

bool is(const json& variant, const char* setting) {
  return variant.get<std::string>().find(setting) != std::string::npos;
}

const char* title_of(const std::string& table) {
  if (table == "a") return "Table I-a: as in 2011 (scalar elementary test and CSAT, literal O-Set, boxes in the hash)";
  if (table == "b") return "Table I-b: the paper's elementary test, with today's baselines";
  return "Table I-c: certified elementary tests";
}

/// In other motions and edges than those of the paper's table, fewer are compared.
std::vector<Entrant> entrants_of(const Registry& registry, const std::string& table, MotionModel model, EdgeSet edges) {
  const bool beside = model != MotionModel::linear || edges != EdgeSet::triangulated;
  if (table == "a")
    return {entrant(registry, "a", "NavCCD-2011"), entrant(registry, "a", "HashCCD-2011"),
            entrant(registry, "a", "VolCCD-2011")};
  const std::vector<std::string> test =
      table == "b" ? std::vector<std::string>{"narrow-phase=cubic"} : std::vector<std::string>{};
  std::vector<std::string> apart = test, filtered = test;
  apart.push_back(kNoAdjacent);
  filtered.push_back(kFiltered);
  std::vector<Entrant> entrants = {
      entrant(registry, table, "NavCCD", test), entrant(registry, table, "VolCCD", test),
      table == "b" ? entrant(registry, table, "VolCCD-2011", test) : entrant(registry, table, "VolCCD+")};
  if (!beside) {
    entrants.push_back(entrant(registry, table, "HashCCD", test));
    for (const auto& settings : {apart, filtered}) entrants.push_back(entrant(registry, table, "NavCCD", settings));
  }
  if (model == MotionModel::query) {
    entrants.push_back(entrant(registry, table, "VolCCD+"));
    entrants.back().variant = kWithoutSeparation;
    entrants.back().without_separation = true;
  }
  return entrants;
}

bool has_hexahedra(const std::string& file) {
  SequenceCells cells;
  SequenceReader(file).read_cells(0, cells);
  return std::find(cells.types.begin(), cells.types.end(), ElementType::hexahedron) != cells.types.end();
}

/// The results of one table for one scene.
struct Comparison {
  Comparison(const Rows& rows, const std::string& table) {
    const auto of = [&](const std::string& name) {
      return rows.with("pipeline", table == "a" ? name + "-2011" : name);
    };
    const auto plain = [](const Rows& all) {
      Rows result = all;
      for (const json& variant : all.values("variant"))
        if (!is(variant, kNoAdjacent) && !is(variant, kFiltered) && !is(variant, kWithoutSeparation))
          result = all.with("variant", variant);
      return result;
    };
    nav = plain(of("NavCCD"));
    hash = of("HashCCD");
    vol = of("VolCCD");
    plus = plain(rows.with("pipeline", "VolCCD+"));
    if (table == "b") printed = rows.with("pipeline", "VolCCD-2011");
    for (const json& variant : rows.values("variant")) {
      if (is(variant, kNoAdjacent)) apart = rows.with("variant", variant);
      if (is(variant, kFiltered)) filtered = rows.with("variant", variant);
      if (is(variant, kWithoutSeparation)) plus_without_separation = rows.with("variant", variant);
    }
  }
  Rows nav, hash, vol, plus, apart, filtered, plus_without_separation;
  Rows printed;  ///< VolCCD-2011 with the test of table b

  double share_of_tests(const Rows& of) const { return nav.tests() > 0 ? of.tests() / nav.tests() : 0; }
};

RatioInterval over(const Rows& baseline, const Rows& of) { return ratio_of_times(baseline, of, kStepAndEditTime); }
std::string over_text(const Rows& baseline, const Rows& of) {
  return baseline.empty() ? "-" : interval_text(over(baseline, of));
}

/// Nanoseconds of an elementary test.
double test_cost(const Rows& rows) {
  return rows.tests() > 0 ? 1e9 * (rows.sum("narrow_phase_run_s") + rows.sum("narrow_phase_prepare_s")) / rows.tests()
                          : 0;
}

std::string milliseconds(const Rows& rows) { return rows.empty() ? "-" : number_text(rows.mean_ms(kStepAndEditTime)); }

/// Calls visit(table, scene, comparison) for each group of rows that is one line of a table. Pre: the rows have one
/// motion model and one set of edges.
template <class Visitor>
void for_each_line(const Rows& rows, Visitor&& visit) {
  for (const Rows& some : rows.groups({"table", "scene"}))
    visit(some.value("table").get<std::string>(), some.value("scene").get<std::string>(),
          Comparison(some, some.value("table")));
}

/// Returns "yes" if all entrants found the contacts of NavCCD in all steps, else the names of those that did not.
std::string same_contacts(const Comparison& c) {
  const std::vector<json> steps = c.nav.values("step");
  const auto differs = [&](const Rows& rows) {
    return std::any_of(steps.begin(), steps.end(), [&](const json& step) {
      const Rows some = rows.with("step", step);
      return !some.empty() && some.values("contacts_hash") != c.nav.with("step", step).values("contacts_hash");
    });
  };
  const std::pair<const char*, const Rows*> others[] = {{"HashCCD", &c.hash},      {"VolCCD", &c.vol},
                                                        {"VolCCD+", &c.plus},      {"2011", &c.printed},
                                                        {"no adjacent", &c.apart}, {"filtered", &c.filtered}};
  std::string result;
  for (const auto& [name, rows] : others)
    if (differs(*rows)) result += (result.empty() ? "not " : ", ") + std::string(name);
  return result.empty() ? "yes" : result;
}

std::vector<std::string> header_of(const std::string& table, bool without_separation) {
  std::vector<std::string> header = {"scene", "elements", "steps", "NavCCD", "HashCCD", "VolCCD"};
  if (table == "c") header.push_back("VolCCD+");
  if (table == "b") header.push_back("2011");
  for (const char* name : {"/Nav", "paper, /Nav", "/Hash", "paper, /Hash"}) header.push_back(name);
  if (table == "c") header.insert(header.end(), {"+/Nav", "+/Hash"});
  if (without_separation) header.push_back("+/+0");
  return header;
}

/// The cells below header_of().
std::vector<std::string> line_of(const std::string& table, bool without_separation, const std::string& scene,
                                 const Comparison& c) {
  const auto paper = kPrintedRows.find(scene);
  const auto printed = [&](const char* PaperRow::*column) {
    return std::string(paper == kPrintedRows.end() ? "-" : paper->second.*column);
  };
  std::vector<std::string> line = {scene,
                                   grouped(static_cast<std::uint64_t>(c.nav.median("elements"))),
                                   std::to_string(c.nav.steps()),
                                   milliseconds(c.nav),
                                   milliseconds(c.hash),
                                   milliseconds(c.vol)};
  if (table == "c") line.push_back(milliseconds(c.plus));
  if (table == "b") line.push_back(milliseconds(c.printed));
  for (const std::string& cell :
       {over_text(c.nav, c.vol), printed(&PaperRow::over_nav), over_text(c.hash, c.vol), printed(&PaperRow::over_hash)})
    line.push_back(cell);
  if (table == "c") line.insert(line.end(), {over_text(c.nav, c.plus), over_text(c.hash, c.plus)});
  if (without_separation) line.push_back(over_text(c.plus, c.plus_without_separation));
  return line;
}

std::string note_of(const std::string& table, const std::string& model, bool without_separation) {
  std::string note =
      "ms a step: mean over steps of medians over rounds, edits of the topology included; /Nav, /Hash: speed-up of "
      "VolCCD "
      "over them, with the 95 % interval over steps and rounds, and the paper's beside it";
  if (table == "c") note += "; +: of VolCCD+";
  if (table == "b") note += "; 2011: VolCCD-2011 with this test";
  if (model == "query") note += "; query: the last one of the simulation before each frame, with its separation";
  if (without_separation) note += "; +/+0: time of VolCCD+ over its time without the separation";
  return note + "\n";
}

TitledTable times(const Rows& rows, const std::string& table, const std::string& model, const std::string& edges) {
  const bool without_separation = !rows.with("variant", kWithoutSeparation).empty();
  TextTable text(header_of(table, without_separation));
  for_each_line(rows, [&](const std::string& of, const std::string& scene, const Comparison& c) {
    if (of == table && !c.nav.empty()) text.add(line_of(table, without_separation, scene, c));
  });
  return {fmt::format("{}; {} motion, {} edges", title_of(table), model, edges), text,
          note_of(table, model, without_separation)};
}

/// Contributions to the speed-up: fewer tests, a cheaper test, and the cost of the other stages.
TitledTable explanation(const Rows& rows, const std::string& table, const std::string& model,
                        const std::string& edges) {
  TextTable text({"scene", "tests, NavCCD", "VolCCD", "ratio", "paper", "ns/test Nav", "Vol", "by culling", "by cost",
                  "other", "no adjacent", "filtered", "same"});
  for_each_line(rows, [&](const std::string& of, const std::string& scene, const Comparison& c) {
    if (of != table || c.nav.empty() || c.vol.empty()) return;
    const auto paper = kPrintedRows.find(scene);
    const double saved =
        1e6 * (c.nav.mean_ms(kStepTime) - c.vol.mean_ms(kStepTime)) * static_cast<double>(c.nav.steps());
    const double culled = (c.nav.tests() - c.vol.tests()) * test_cost(c.nav);
    const double cheaper = c.vol.tests() * (test_cost(c.nav) - test_cost(c.vol));
    const auto share = [&](double part) {
      return saved > 0 ? fixed_text(100 * part / saved, 0) + " %" : std::string("-");
    };
    text.add({scene, grouped(static_cast<std::uint64_t>(c.nav.tests())),
              grouped(static_cast<std::uint64_t>(c.vol.tests())), percent_text(c.share_of_tests(c.vol)),
              paper == kPrintedRows.end() ? "-" : paper->second.ratio, number_text(test_cost(c.nav)),
              number_text(test_cost(c.vol)), share(culled), share(cheaper), share(saved - culled - cheaper),
              milliseconds(c.apart), milliseconds(c.filtered), same_contacts(c)});
  });
  return {fmt::format("What explains the speed-up of VolCCD in Table I-{}; {} motion, {} edges", table, model, edges),
          text,
          "tests: sum over steps; by culling: tests left out times NavCCD's cost of a test, by cost: tests performed "
          "times the difference in cost, "
          "both as shares of the time saved; other: what else VolCCD spends or saves; no adjacent: ms a step of NavCCD "
          "on non-adjacent pairs "
          "and an O-Set; filtered: of NavCCD with filters of its tests, which the paper's has not; same: whether all "
          "found NavCCD's contacts, bit for bit, or who did not\n"};
}

/// Figures 4 and 11 as numbers.
TitledTable shares(const Rows& all, const std::string& table) {
  TextTable text({"scene", "k-DOPs", "tree", "traversal+culling", "O-Set", "filters", "tests", "rest", "edits, ms",
                  "touch nothing"});
  for_each_line(all.with("motion_model", "linear").with("edges", "triangulated"),
                [&](const std::string& of, const std::string& scene, const Comparison& c) {
                  if (of != table || c.vol.empty()) return;
                  const double whole = c.vol.sum("seconds") * c.vol.front().at("threads").get<double>();
                  double known = 0;
                  const auto share = [&](const std::vector<std::string>& columns, double less = 0) {
                    double sum = -less;
                    for (const std::string& column : columns) sum += c.vol.sum(column);
                    known += sum;
                    return fixed_text(100 * sum / whole, 1);
                  };
                  std::vector<std::string> row = {
                      scene,
                      share({"bounds_s"}),
                      share({"broad_phase_prepare_s"}, c.vol.sum("bounds_s")),
                      share({"broad_phase_run_s", "element_culling_prepare_s", "element_culling_run_s",
                             "assignment_prepare_s", "assignment_run_s"}),
                      share({"orphans_prepare_s", "orphans_run_s"}),
                      share({"feature_filter_prepare_s", "feature_filter_run_s"}),
                      share({"narrow_phase_prepare_s", "narrow_phase_run_s"})};
                  row.push_back(fixed_text(100 * (whole - known) / whole, 1));
                  row.push_back(number_text(c.vol.mean_ms({"topology_seconds"})));
                  const double pairs = c.vol.sum("element_pairs");
                  row.push_back(pairs > 0 ? percent_text(1 - c.vol.sum("touching_pairs") / pairs) : "-");
                  text.add(row);
                });
  return {fmt::format("Figures 11 and 4: shares of VolCCD's time in Table I-{}, %, and leaf pairs that touch nothing",
                      table),
          text, "touch nothing: of non-adjacent pairs of elements whose k-DOPs overlap (the paper: 90 to 99 %)\n"};
}

json summary_of(const std::string& table, const std::string& scene, const Comparison& c) {
  json line = {{"table", table},
               {"scene", scene},
               {"motion_model", c.nav.front().at("motion_model")},
               {"edges", c.nav.front().at("edges")},
               {"elements", c.nav.median("elements")},
               {"steps", c.nav.steps()},
               {"culling_ratio_percent", 100 * c.share_of_tests(c.vol)}};
  const auto add_speedup = [&](const std::string& key, const Rows& baseline, const Rows& of) {
    if (baseline.empty()) return;
    const RatioInterval ratio = over(baseline, of);
    line[key] = ratio.value;
    line[key + "_interval"] = {ratio.low, ratio.high};
  };
  add_speedup("speedup_navccd", c.nav, c.vol);
  add_speedup("speedup_hashccd", c.hash, c.vol);
  const auto add_time = [&](const char* name, const Rows& rows) {
    if (!rows.empty()) line[std::string(name) + "_ms"] = rows.mean_ms(kStepAndEditTime);
  };
  add_time("navccd", c.nav), add_time("hashccd", c.hash), add_time("volccd", c.vol), add_time("volccd_plus", c.plus);
  add_time("navccd_without_adjacent", c.apart), add_time("navccd_filtered", c.filtered);
  if (!c.plus.empty()) {
    add_speedup("speedup_navccd_plus", c.nav, c.plus);
    add_speedup("speedup_hashccd_plus", c.hash, c.plus);
    add_speedup("speedup_navccd_filtered_plus", c.filtered, c.plus);
    add_speedup("separation_costs_plus", c.plus, c.plus_without_separation);
    line["culling_ratio_percent_plus"] = 100 * c.share_of_tests(c.plus);
  }
  return line;
}

}  // namespace

ExperimentPlan table1_plan(const PlanContext& context) {
  ExperimentPlan plan{"table1", context.full ? "full" : "quick", context.full ? kFullRounds : 1, {}};
  if (context.full) plan.processes = kFullProcesses;
  for (const TableScene& scene : table_scenes(context)) {
    const auto add = [&](const std::string& table, MotionModel model, EdgeSet edges) {
      SceneRun run{scene.name, scene.file, table_config(scene.file, model), table_windows(context, scene.file), {}};
      run.config.edge_set = edges;
      run.entrants = entrants_of(context.registry, table, model, edges);
      if (table == "c")
        for (const std::string& pipeline : context.pipelines)
          run.entrants.push_back(entrant(context.registry, table, pipeline));
      plan.runs.push_back(std::move(run));
    };
    const bool of_paper = !context.own_scenes.empty() || kPrintedRows.count(scene.name) > 0;
    for (const char* table : {"a", "b", "c"})
      if (of_paper || *table == 'c') add(table, MotionModel::linear, EdgeSet::triangulated);
    const SequenceReader reader(scene.file);
    if (context.full && reader.has_velocity()) add("c", MotionModel::tentative, EdgeSet::triangulated);
    if (context.full && reader.has_query()) add("c", MotionModel::query, EdgeSet::triangulated);
    if (context.full && of_paper && has_hexahedra(scene.file)) add("b", MotionModel::linear, EdgeSet::polytope);
  }
  return plan;
}

std::vector<TitledTable> table1_tables(const json& record) {
  const Rows rows(record);
  std::vector<TitledTable> tables;
  for (const Rows& some : rows.groups({"motion_model", "edges"}))
    for (const json& table : some.values("table")) {
      tables.push_back(times(some, table, some.value("motion_model"), some.value("edges")));
      tables.push_back(explanation(some, table, some.value("motion_model"), some.value("edges")));
    }
  for (const json& table : rows.values("table")) tables.push_back(shares(rows, table));
  tables[0].note += "setting " + record.at("provenance").at("setting").get<std::string>() + ", commit " +
                    record.at("provenance").at("commit").get<std::string>() + "\n";
  return tables;
}

json table1_summary(const json& record) {
  const Rows rows(record);
  json summary = json::array();
  for (const Rows& some : rows.groups({"motion_model", "edges"}))
    for_each_line(some, [&](const std::string& table, const std::string& scene, const Comparison& c) {
      if (!c.nav.empty()) summary.push_back(summary_of(table, scene, c));
    });
  return summary;
}

}  // namespace volccd
