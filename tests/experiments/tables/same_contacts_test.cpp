// Finds the entrants with other contacts: the harness after a run, and the column "same" of Table I.
#include <gtest/gtest.h>

#include <volccd/experiments/tables/table1.hpp>

#include "experiments/harness/harness_fixture.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

class SameContacts : public Harness {
 protected:
  /// All entrants with the narrow phase `cubic`, including VolCCD-2011, and NavCCD also with `exact`.
  ExperimentPlan cubic_plan() const {
    ExperimentPlan result = plan(1, {{2, 3}});
    result.runs[0].entrants.clear();
    for (const char* pipeline : {"NavCCD", "VolCCD-2011", "HashCCD", "VolCCD"})
      result.runs[0].entrants.push_back(entrant(registry_, "b", pipeline, {"narrow-phase=cubic"}));
    result.runs[0].entrants.push_back(entrant(registry_, "b", "NavCCD", {"narrow-phase=exact"}));
    return result;
  }
  /// Rows as in a record of the plan, with the same contacts for all entrants.
  static std::vector<json> agreeing_rows(const ExperimentPlan& plan) {
    std::vector<json> rows;
    for (const SceneRun& run : plan.runs)
      for (int motion = 2; motion < 5; ++motion)
        for (const Entrant& entrant : run.entrants)
          rows.push_back({{"table", entrant.table},
                          {"scene", run.scene},
                          {"motion_model", name_of(run.config.motion)},
                          {"edges", name_of(run.config.edge_set)},
                          {"pipeline", entrant.pipeline},
                          {"variant", entrant.variant},
                          {"step", motion},
                          {"contacts_hash", "1f"},
                          {"contacts", 7},
                          {"undecided", 0}});
    return rows;
  }
  static json& row_of(std::vector<json>& rows, const std::string& pipeline, const std::string& test, int motion) {
    for (json& row : rows)
      if (row.at("pipeline") == pipeline && row.at("variant") == "narrow-phase=" + test && row.at("step") == motion)
        return row;
    throw Error("no such row");
  }
};

TEST_F(SameContacts, NoLineWhereAllAgree) {
  const ExperimentPlan plan = cubic_plan();
  EXPECT_TRUE(contact_differences(registry_, plan, agreeing_rows(plan)).empty());
}

TEST_F(SameContacts, ALineForEachPipelineThatDiffersWithItsFirstMotion) {
  const ExperimentPlan plan = cubic_plan();
  std::vector<json> rows = agreeing_rows(plan);
  for (const int motion : {3, 4}) {
    json& row = row_of(rows, "VolCCD", "cubic", motion);
    row["contacts_hash"] = "2e";
    row["contacts"] = 6;
  }
  const std::vector<std::string> lines = contact_differences(registry_, plan, rows);
  ASSERT_EQ(lines.size(), 1u);
  for (const char* part : {"block, step 3", "VolCCD narrow-phase=cubic found 6", "NavCCD narrow-phase=cubic 7"})
    EXPECT_NE(lines[0].find(part), std::string::npos) << lines[0];
  row_of(rows, "HashCCD", "cubic", 2)["contacts_hash"] = "2e";
  EXPECT_EQ(contact_differences(registry_, plan, rows).size(), 2u);
}

TEST_F(SameContacts, ApproximatePipelinesAndOtherNarrowPhasesAreNotCompared) {
  const ExperimentPlan plan = cubic_plan();
  std::vector<json> rows = agreeing_rows(plan);
  row_of(rows, "VolCCD-2011", "cubic", 2)["contacts_hash"] = "2e";
  row_of(rows, "NavCCD", "exact", 3)["contacts_hash"] = "3d";
  EXPECT_TRUE(contact_differences(registry_, plan, rows).empty());
}

TEST_F(SameContacts, Table1NamesWhoFoundOthers) {
  const PlanContext context{registry_, false, {}, {}, [&](const std::string&) { return std::optional(file_); }};
  ExperimentPlan plan = table1_plan(context);
  const auto table_b = std::find_if(plan.runs.begin(), plan.runs.end(),
                                    [](const SceneRun& run) { return run.entrants[0].table == "b"; });
  ASSERT_NE(table_b, plan.runs.end());
  plan.runs = {*table_b};
  std::vector<json> rows = rows_of(plan, 1, "table1");
  for (json& row : rows) row["contacts_hash"] = "1f";
  const auto same = [&] {
    const std::string table =
        table1_tables({{"rows", rows}, {"provenance", {{"setting", "quick"}, {"commit", "c"}}}}).at(1).table.text();
    const std::size_t end = table.find_last_not_of("\n");
    return table.substr(0, end + 1);
  };
  EXPECT_TRUE(same().ends_with(" yes")) << same();
  const auto alter = [&](const std::string& pipeline) {
    for (json& row : rows)
      if (row.at("pipeline") == pipeline) row["contacts_hash"] = "2e";
  };
  alter("VolCCD-2011");
  EXPECT_TRUE(same().ends_with(" not 2011")) << same();
  alter("HashCCD");
  EXPECT_TRUE(same().ends_with(" not HashCCD, 2011")) << same();
}

}  // namespace
}  // namespace volccd::test
