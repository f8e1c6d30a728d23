// The table of coplanarity against CSAT: from rows whose numbers are known, and from a run.
#include <volccd/experiments/tables/ablation.hpp>
#include <volccd/experiments/tables/coplanarity_table.hpp>
#include <volccd/io/stats_json.hpp>

#include <set>

#include "experiments/harness/harness_fixture.hpp"
#include "support/table_cells.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

/// 100 tests of pairs and 100 of the O-Set, of which `left` are left.
json row(const char* variant, double filter_seconds, double culling_seconds, int left) {
  return {{"table", kCoplanarityTable},
          {"scene", "octopi"},
          {"pipeline", "VolCCD"},
          {"variant", variant},
          {"step", 3},
          {"round", 0},
          {"elements", 10},
          {"seconds", 0.002},
          {"topology_seconds", 0},
          {"element_culling_prepare_s", 0},
          {"element_culling_run_s", culling_seconds},
          {"feature_filter_prepare_s", 0},
          {"feature_filter_run_s", filter_seconds},
          {"owned_tests", culling_seconds > 0 ? 20 : 100},
          {"orphan_tests", culling_seconds > 0 ? 80 : 100},
          {"vf_tests", left},
          {"ee_tests", 0},
          {"contacts", 4}};
}

TEST(CoplanarityTable, HasTimesOfATestOverThoseOfCsatAndTestsLeft) {
  const json record = {{"rows",
                        {row("none", 0, 0, 200), row("CSAT", 2e-6, 0, 50), row("coplanarity", 6e-6, 0, 20),
                         row("elements: CSAT, none", 0, 5e-7, 100), row("elements: CSAT, CSAT", 1e-6, 5e-7, 25),
                         row("elements: CSAT, coplanarity", 4e-6, 5e-7, 10)}}};
  const std::vector<TitledTable> tables = ablation_tables(record);
  ASSERT_EQ(tables.size(), 1u);
  const TitledTable& table = tables[0];
  EXPECT_NE(table.title.find("Section 7.2"), std::string::npos);
  ASSERT_EQ(table.table.rows().size(), 7u);
  EXPECT_EQ(cell(table, 2, "features"), "10") << "2 us for 200 tests";
  EXPECT_EQ(cell(table, 3, "/ CSAT, features"), "3x");
  EXPECT_EQ(cell(table, 3, "/ CSAT, elements"), "6x") << "30 ns a test, and 5 ns for each of the 100 tests of pairs";
  EXPECT_EQ(cell(table, 3, "tests left"), "20");
  EXPECT_EQ(cell(table, 3, "left"), "10 %");
  EXPECT_EQ(cell(table, 6, "ns/test, elements"), "5");
  EXPECT_EQ(cell(table, 6, "/ CSAT, features"), "4x") << "over the line that culls elements as well";
  EXPECT_EQ(cell(table, 6, "/ CSAT, elements"), "-");
  for (const std::size_t line : {1u, 2u, 4u, 5u})
    for (const char* paper : {"paper, features", "paper, elements"}) EXPECT_EQ(cell(table, line, paper), "-") << line;
  const auto& cells = table.table.rows();
  EXPECT_EQ(cells[3].at(5), "2x");
  EXPECT_EQ(cells[3].at(7), "6x");
}

/// The pipelines differ in culling alone: the same motions, the same contacts, and fewer tests with more culling.
TEST_F(Harness, CoplanarityAndCsatAreComparedOnTheSameMotions) {
  const PlanContext context{registry_, false, {}, {}, [&](const std::string& name) {
                              return name == "octopi-quick" ? std::optional(file_) : std::nullopt;
                            }};
  ExperimentPlan plan = ablation_plan(context);
  ASSERT_EQ(plan.runs.size(), 2u);
  EXPECT_EQ(plan.runs[0].windows.at(0).first, plan.runs[1].windows.at(0).first);
  plan.runs.erase(plan.runs.begin());
  ASSERT_EQ(plan.runs[0].entrants.size(), 8u);
  for (const Entrant& one : plan.runs[0].entrants) EXPECT_EQ(one.table, kCoplanarityTable);
  EXPECT_GE(plan.runs[0].rounds, 3) << "one round of a busy machine is no measurement of a short stage";
  plan.runs[0].rounds = 1;
  std::set<std::string> unlike;  // what is left of the stages without those of culling
  for (const Entrant& one : plan.runs[0].entrants) {
    PipelineSpec spec = one.spec;
    spec.element_culling.clear(), spec.feature_filters.clear();
    unlike.insert(volccd::to_json(spec).dump());
  }
  EXPECT_EQ(unlike.size(), 1u);
  plan.runs[0].windows = {{3, 2}};
  const std::vector<json> rows = rows_of(plan, 1, "ablation");
  EXPECT_EQ(rows.size(), 8u * 2);
  EXPECT_TRUE(contact_differences(registry_, plan, rows).empty());
  std::map<std::string, double> left;
  for (const json& row : rows)
    left[row.at("variant")] += row.at("vf_tests").get<double>() + row.at("ee_tests").get<double>();
  for (const std::string elements : {"", "elements: CSAT, "}) {
    EXPECT_LE(left.at(elements + "none"), left.at("none"));
    for (const std::string one : {"CSAT", "coplanarity"}) {
      EXPECT_LT(left.at(elements + one), left.at(elements + "none"));
      EXPECT_LE(left.at(elements + "coplanarity + CSAT"), left.at(elements + one));
    }
  }
  const std::string text = render(ablation_tables({{"rows", rows}}), TableFormat::text);
  EXPECT_NE(text.find("6x"), std::string::npos) << text;
}

}  // namespace
}  // namespace volccd::test
