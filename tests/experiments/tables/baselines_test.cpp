// Table I-d, and the intervals of its ratios.
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <volccd/experiments/tables/baselines.hpp>
#include <volccd/experiments/tables/interval.hpp>

#include "experiments/described_keys.hpp"
#include "experiments/harness/harness_fixture.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

/// Rows of steps 1, 2, ..., each with one round for each given time.
json rows_of_times(const std::vector<std::vector<double>>& steps) {
  json rows = json::array();
  for (std::size_t step = 0; step < steps.size(); ++step)
    for (const double seconds : steps[step]) rows.push_back({{"step", step + 1}, {"seconds", seconds}});
  return {{"rows", rows}};
}

RatioInterval ratio(const json& above, const json& below) {
  return ratio_of_times(Rows(above), Rows(below), kStepTime);
}

TEST(RatioInterval, IsAPointWhereNothingVaries) {
  const RatioInterval point = ratio(rows_of_times({{6, 6}, {3, 3}, {12, 12}}), rows_of_times({{2, 2}, {1, 1}, {4, 4}}));
  EXPECT_EQ(point.value, 3);
  EXPECT_EQ(point.low, 3);
  EXPECT_EQ(point.high, 3) << "steps are drawn for both alike";
  EXPECT_EQ(interval_text(point), "3x");
  EXPECT_EQ(interval_text({}), "-");
}

TEST(RatioInterval, CoversStepsAndRounds) {
  const json below = rows_of_times({{1}, {1}, {1}, {1}});
  const RatioInterval steps = ratio(rows_of_times({{1}, {2}, {3}, {4}}), below);
  EXPECT_EQ(steps.value, 2.5);
  EXPECT_LT(steps.low, 1.8);
  EXPECT_GT(steps.high, 3.2);
  const json noisy = rows_of_times({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}});
  const RatioInterval rounds = ratio(noisy, below);
  EXPECT_EQ(rounds.value, 2) << "the median";
  EXPECT_LT(rounds.low, 1.8);
  EXPECT_GT(rounds.high, 2.2);
  EXPECT_EQ(ratio(noisy, below).low, rounds.low) << "the same rows";
  EXPECT_EQ(ratio(rows_of_times({{5}}), rows_of_times({{2}, {7}})).value, 2.5) << "the common step";
}

/// Half of the intervals of normally distributed ratios around 2 would miss it if they were too narrow by half.
TEST(RatioInterval, ContainsTheTrueRatioAboutAsOftenAsItSays) {
  std::mt19937_64 random(7);
  const auto noise = [&] {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() % 1000000) / 1e6;
    return sum - 6;  // nearly normal, of variance 1
  };
  int contained = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<std::vector<double>> above, below;
    for (int step = 0; step < 12; ++step) {
      above.emplace_back(), below.emplace_back();
      const double scale = 1 + 0.2 * noise();
      for (int round = 0; round < 5; ++round) {
        above.back().push_back(scale * 2 + 0.2 * noise());
        below.back().push_back(1 + 0.1 * noise());
      }
    }
    const RatioInterval interval = ratio(rows_of_times(above), rows_of_times(below));
    contained += interval.low <= 2 && 2 <= interval.high;
  }
  EXPECT_GE(contained, kTrials * 85 / 100);
  EXPECT_LT(contained, kTrials + 1);
}

TEST(RatioInterval, TextHasTheDigitsThatAreCertain) {
  EXPECT_EQ(interval_text({71.26, 66.4, 77.1}), "71x (66 to 77)");
  EXPECT_EQ(interval_text({7.42, 7.1, 7.66}), "7.4x (7.1 to 7.7)");
  EXPECT_EQ(interval_text({7.2, 5.94, 8.86}), "7.2x (5.9 to 8.9)");
  EXPECT_EQ(interval_text({0.971, 0.9655, 0.9755}), "0.97x (0.97 to 0.98)") << "two digits at most";
}

class Baselines : public Harness {
 protected:
  json record(std::vector<std::string> own = {}) {
    ExperimentPlan plan = baselines_plan({registry_, false, std::move(own), {}, [&](const std::string& name) {
                                            return name == "octopi-quick" ? std::optional(file_) : std::nullopt;
                                          }});
    plan.runs.front().windows = {{1, 7}};
    return {{"rows", rows_of(plan, 1, "baselines")}};
  }
};

TEST_F(Baselines, AllFindTheSameContacts) {
  std::map<int, std::set<std::string>> hashes;
  std::set<std::string> entrants;
  const json made = record();
  for (const json& row : made.at("rows")) {
    hashes[row.at("step")].insert(row.at("contacts_hash"));
    entrants.insert(row.at("pipeline").get<std::string>() + "/" + row.at("variant").get<std::string>());
  }
  EXPECT_GE(entrants.size(), 8u);
  for (const auto& [motion, of] : hashes) EXPECT_EQ(of.size(), 1u) << "motion " << motion;
}

TEST_F(Baselines, TheStrongestIsTheFastestThatIsNotOurs) {
  json made = record();
  for (json& row : made["rows"]) {  // times by entrant, so that the answer is known
    const std::string name = row.at("pipeline").get<std::string>() + "/" + row.at("variant").get<std::string>();
    row["topology_seconds"] = 0;
    row["seconds"] = name == "NavCCD/"                       ? 0.5
                     : name == "NavCCD/no adjacent, filters" ? 0.02
                     : name == "VolCCD+/"                    ? 0.01
                                                             : 0.1;
  }
  const json line = baselines_summary(made).at(0);
  EXPECT_EQ(line.at("strongest"), "with filters");
  EXPECT_NEAR(line.at("speedup_strongest_plus").get<double>(), 2, 1e-9);
  EXPECT_NEAR(line.at("speedup_strongest").get<double>(), 0.2, 1e-9) << "VolCCD loses";
  EXPECT_NEAR(line.at("speedup_navccd_plus").get<double>(), 50, 1e-9);
  EXPECT_NEAR(line.at("gain_both").get<double>(), 10, 1e-9);
  expect_described(line, "baselines_summary");
}

TEST_F(Baselines, TablesHaveStepsWithAndWithoutContactsAndPipelinesOfTheCaller) {
  json made = record({"HashCCD"});
  for (json& row : made["rows"])
    if (row.at("step") < 3) row["contacts"] = 0;
  const std::vector<TitledTable> tables = baselines_tables(made);
  EXPECT_NE(render(tables, TableFormat::text).find("HashCCD"), std::string::npos);
  EXPECT_EQ(tables.size(), 5u) << "none of seeds";
  const auto cells = tables.at(3).table.rows().at(1);
  EXPECT_EQ(cells.at(1), "5") << "with contacts";
  EXPECT_EQ(cells.at(4), "2");
}

TEST_F(Baselines, SeedsHaveATableOfTheirOwn) {
  ExperimentPlan plan = baselines_plan({registry_, true, {}, {}, [&](const std::string& name) {
                                          return name.starts_with("octopi") ? std::optional(file_) : std::nullopt;
                                        }});
  ASSERT_EQ(plan.runs.size(), 4u) << "the scene, and three seeds";
  plan.rounds = plan.processes = 1;
  for (SceneRun& run : plan.runs) run.windows = {{1, 2}};
  const json made = {{"rows", rows_of(plan, 1, "seeds")}};
  EXPECT_EQ(baselines_summary(made).size(), 1u);
  const std::vector<TitledTable> tables = baselines_tables(made);
  EXPECT_EQ(tables.at(0).table.rows().size(), 2u) << "a header, and the scene";
  ASSERT_EQ(tables.size(), 6u);
  EXPECT_EQ(tables.at(5).table.rows().size(), 4u);
  EXPECT_EQ(tables.at(5).table.rows().at(2).at(0), "octopi-quick-seed-2");
}

}  // namespace
}  // namespace volccd::test
