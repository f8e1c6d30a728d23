// The experiment `first-steps` on a small scene: its rows, and tables and summary of a record with known figures.
#include <volccd/experiments/tables/first_steps.hpp>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/scene.hpp>

#include "experiments/made_rows.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

class FirstStepsExperiment : public testing::Test {
 protected:
  PlanContext context(const std::string& available) {
    return {registry_, false, {}, {}, [this, available](const std::string& name) {
              return name == available ? std::optional(file_) : std::nullopt;
            }};
  }

  const Registry registry_ = Registry::standard();
  const ScratchFolder folder_;
  const std::string file_ = folder_ / "scene.vtkhdf";
};

TEST_F(FirstStepsExperiment, RowsHaveTheParts) {
  write_scene(*make_scene("builtin", {{"elements", "150"}, {"frames", "4"}}), file_);
  const std::vector<json> rows = made_rows(first_steps_rows, context("cloth-ball"));
  ASSERT_EQ(rows.size(), 5u);
  for (std::size_t round = 0; round < rows.size(); ++round) {
    const json& row = rows[round];
    EXPECT_EQ(row.at("scene"), "cloth-ball");
    EXPECT_EQ(row.at("round"), round);
    EXPECT_EQ(row.at("step"), 0);
    double sum = 0;
    for (const char* part : {"topology_s", "tree_s", "tables_s", "rest_s"}) {
      EXPECT_GT(row.at(part).get<double>(), 0) << part;
      sum += row.at(part).get<double>();
    }
    EXPECT_NEAR(row.at("first_s").get<double>(), sum, 1e-12);
    EXPECT_GT(row.at("later_s").get<double>(), 0);
    EXPECT_GT(row.at("workspace_bytes").get<double>(), 0);
  }
}

TEST_F(FirstStepsExperiment, TheOnlyMotionOfASequenceIsRepeated) {
  write_scene(*make_scene("builtin", {{"elements", "150"}, {"frames", "2"}}), file_);
  for (const json& row : made_rows(first_steps_rows, context("cloth-ball")))
    EXPECT_GT(row.at("later_s").get<double>(), 0);
}

TEST_F(FirstStepsExperiment, TablesAndSummary) {
  json rows = json::array();
  for (int round = 0; round < 3; ++round)
    rows.push_back({{"scene", "a"},
                    {"round", round},
                    {"step", 7},
                    {"threads", 2},
                    {"elements", 1000},
                    {"topology_s", 0.001 * round},
                    {"tree_s", 0.002},
                    {"tables_s", 0.003},
                    {"rest_s", 0.004},
                    {"first_s", 0.01 + 0.001 * round},
                    {"later_s", 0.0022},
                    {"workspace_bytes", 450000}});
  const json record = {{"rows", rows}};
  const json summary = first_steps_summary(record);
  ASSERT_EQ(summary.size(), 1u);
  EXPECT_EQ(summary[0].at("scene"), "a");
  EXPECT_NEAR(summary[0].at("topology_ms").get<double>(), 1, 1e-9);
  EXPECT_NEAR(summary[0].at("first_ms").get<double>(), 11, 1e-9);
  EXPECT_NEAR(summary[0].at("ratio").get<double>(), 5, 1e-9);
  EXPECT_NEAR(summary[0].at("bytes_per_element").get<double>(), 450, 1e-9);
  const std::vector<TitledTable> tables = first_steps_tables(record);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_NE(tables[0].table.text().find("450"), std::string::npos);
}

TEST_F(FirstStepsExperiment, NoSceneIsAnError) {
  EXPECT_THROW(made_rows(first_steps_rows, context("none")), ConfigError);
  EXPECT_TRUE(first_steps_plan(context("none")).runs.empty());
}

}  // namespace
}  // namespace volccd::test
