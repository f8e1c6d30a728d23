// The experiment `ranks` on a small scene: its rows, and tables and summary of a record with known figures.
#include <set>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/tables/ranks.hpp>

#include "experiments/described_keys.hpp"
#include "experiments/made_rows.hpp"
#include "support/all_stages.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

class RanksExperiment : public testing::Test {
 protected:
  PlanContext context(const std::string& available) {
    return {registry_, false, {}, {}, [this, available](const std::string& name) {
              return name == available ? std::optional(file_) : std::nullopt;
            }};
  }

  const Registry registry_ = all_stages();
  const ScratchFolder folder_;
  const std::string file_ = folder_ / "scene.vtkhdf";
};

TEST_F(RanksExperiment, RowsOfEachMotionAndNumberOfRanks) {
  write_scene(*make_scene("builtin", {{"elements", "150"}, {"frames", "6"}}), file_);
  std::size_t told = 0;
  PlanContext with_progress = context("octopi-quick");
  with_progress.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_LT(done, total);
    ++told;
  };
  const std::vector<json> rows = made_rows(ranks_rows, with_progress);
  expect_described(rows.at(0), "ranks_row");
  EXPECT_EQ(rows.size(), 3u * 3u * 5u) << "motions, numbers of ranks, rounds";
  EXPECT_EQ(told, 3u * (12u + 5u) * 4u) << "rounds that are not measured, and the whole mesh, too";
  std::set<std::pair<std::string, int>> kinds;
  int lists = 0;
  for (const json& row : rows) {
    kinds.emplace(row.at("case"), row.at("ranks"));
    EXPECT_GT(row.at("slowest_s").get<double>(), 0);
    EXPECT_GE(row.at("slowest_s").get<double>(), row.at("slowest_pipeline_s").get<double>());
    EXPECT_GE(row.at("sum_s").get<double>(), row.at("slowest_s").get<double>());
    EXPECT_GE(row.at("copies").get<double>(), 1);
    EXPECT_GE(row.at("imbalance").get<double>(), 1);
    if (row.at("case") == "rest") {
      EXPECT_EQ(row.at("whole_tests"), row.at("tests")) << "each test is made once";
      lists += row.at("lists").get<int>();
    }
  }
  EXPECT_EQ(kinds.size(), 9u);
  EXPECT_LT(lists, 5) << "of nine steps at rest: lists hold, but where times ask for other regions";
  EXPECT_THROW(made_rows(ranks_rows, context("nothing")), ConfigError);
}

TEST_F(RanksExperiment, TablesAndSummary) {
  json rows = json::array();
  for (int round = 0; round < 3; ++round)
    rows.push_back({{"scene", "a"},
                    {"case", "substep"},
                    {"divisions", 1},
                    {"elements", 1000},
                    {"ranks", 16},
                    {"round", round},
                    {"step", 7},
                    {"threads", 1},
                    {"whole_s", 0.1},
                    {"slowest_s", 0.008 + 0.002 * round},
                    {"sum_s", 0.12},
                    {"imbalance", 1.25},
                    {"copies", 1.5},
                    {"halo", 0.5},
                    {"tests", 210},
                    {"whole_tests", 200},
                    {"bytes_max", 1000000},
                    {"bytes_mean", 500000.0},
                    {"neighbours_max", 10},
                    {"contacts", 5},
                    {"warm_ups", 8}});
  const json record = {{"rows", rows}}, line = ranks_summary(record).at(0);
  EXPECT_NEAR(line.at("speedup_slowest").get<double>(), 10, 1e-9) << "of the median round";
  EXPECT_NEAR(line.at("overhead").get<double>(), 1.2, 1e-9);
  EXPECT_NEAR(line.at("test_ratio").get<double>(), 1.05, 1e-9);
  // 10 ms, 2 x 10 + 5 x 4 latencies of 2 us, 1 MB at 10 GB/s
  EXPECT_NEAR(line.at("modelled_ms").get<double>(), 10 + 0.08 + 0.1, 1e-9);
  const TitledTable table = ranks_tables(record).at(0);
  EXPECT_EQ(table.note.find("medians of 3 rounds after 8 steps,"), 0u) << "of the record, not of the program";
  const auto times = table.table.rows().at(1);
  EXPECT_EQ(times.at(4), "100");
  EXPECT_EQ(times.at(6), "10x");
  expect_described(line, "ranks_summary");
}

}  // namespace
}  // namespace volccd::test
