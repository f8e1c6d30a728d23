#include <volccd/experiments/tables/culling_counts.hpp>

#include <array>

#include <fmt/format.h>

#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Numbers printed in the paper: {VF, EE, total, ratio}.
using PaperLine = std::array<const char*, 4>;
struct PrintedTable {
  const char *scene, *title;
  PaperLine lines[3];
};
constexpr PrintedTable kPrintedTables[] = {
    {"octopi",
     "Table II",
     {{"26M", "312M", "339M", "100%"}, {"1.1M", "6.4M", "7.5M", "2.23%"}, {"7.9K", "24K", "32K", "0.42%"}}},
    {"crash",
     "Table III",
     {{"8.24E+09", "1.6E+10", "2.43E+10", "100%"},
      {"9.8E+07", "3.8E+08", "4.76E+08", "1.96%"},
      {"2.3E+07", "1.2E+08", "1.41E+08", "29.61%"}}}};

constexpr const char* kCulling[] = {"A none", "B features", "C features and elements"};

void add_lines(const Rows& rows, const PrintedTable& paper, TextTable& table) {
  double before = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Rows of = rows.with("pipeline", kCulling[i]);
    if (of.empty()) continue;
    const double steps = static_cast<double>(of.steps()), tests = of.tests();
    const auto text = [](double value) { return grouped(static_cast<std::uint64_t>(value)); };
    table.add({kCulling[i], text(of.sum("vf_tests") / steps), text(of.sum("ee_tests") / steps), text(tests / steps),
               text(tests), i == 0 ? "100 %" : percent_text(before > 0 ? tests / before : 0), paper.lines[i][0],
               paper.lines[i][1], paper.lines[i][2], paper.lines[i][3]});
    before = tests;
  }
}

}  // namespace

ExperimentPlan culling_plan(const PlanContext& context) {
  ExperimentPlan plan{"culling", context.full ? "full" : "quick", 1, {}};
  const Registry& registry = context.registry;
  for (const PrintedTable& paper : kPrintedTables) {
    const auto file = context.file_of(std::string(paper.scene) + (context.full ? "" : "-quick"));
    if (!file) continue;
    SceneRun run{
        paper.scene, *file, table_config(*file), sampled_windows(step_count(*file), context.full ? 8 : 2, 1), {}};
    run.entrants = {entrant(registry, "", "NavCCD-2011"),
                    entrant(registry, "", "VolCCD-2011", {"element-culling=none", "feature-filter=none"}),
                    entrant(registry, "", "VolCCD-2011")};
    for (std::size_t i = 0; i < 3; ++i) run.entrants[i].pipeline = kCulling[i];
    plan.runs.push_back(std::move(run));
  }
  return plan;
}

std::vector<TitledTable> culling_tables(const json& record) {
  const Rows rows(record);
  std::vector<TitledTable> tables;
  for (const PrintedTable& paper : kPrintedTables) {
    const Rows of = rows.with("scene", paper.scene);
    if (of.empty()) continue;
    TextTable table({"culling", "VF/step", "EE/step", "total/step", "total", "ratio", "paper, VF", "paper, EE",
                     "paper, total", "paper, ratio"});
    add_lines(of, paper, table);
    tables.push_back(
        {fmt::format("{}: elementary tests on {}, {} elements, {} steps", paper.title, paper.scene,
                     grouped(static_cast<std::uint64_t>(of.median("elements"))), of.steps()),
         table,
         "ratio: to the line above; total: sum over the steps that were measured. The paper does not say whether "
         "its counts are a step's or all steps': those of Table II in the time of Table I would be 2.7 ns a "
         "test.\n"});
  }
  return tables;
}

}  // namespace volccd
