// The experiment `substeps` on a small scene: the contents of its rows, and an error if lists change contacts.
#include <volccd/experiments/tables/substeps.hpp>

#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/run.hpp>
#include <volccd/experiments/scenes/scene.hpp>

#include "experiments/described_keys.hpp"
#include "experiments/made_rows.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

/// `inclusion`, or that without the last contact of each block.
class MadeUpNarrowPhase final : public NarrowPhase {
 public:
  MadeUpNarrowPhase(std::unique_ptr<NarrowPhase> real, bool loses) : real_(std::move(real)), loses_(loses) {}

  bool handles_separation() const override { return real_->handles_separation(); }
  double time_tolerance() const override { return real_->time_tolerance(); }
  std::unique_ptr<StageState> make_state() const override { return real_->make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    real_->prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    const std::size_t before = contacts.size();
    real_->run(step, state, worker, block, contacts, counters);
    if (loses_ && contacts.size() > before) contacts.pop_back();
  }

 private:
  std::unique_ptr<NarrowPhase> real_;
  bool loses_;
};

/// Stages and pipelines of the library, where each second object of `inclusion` loses contacts: that of the runner with
/// lists, which is made after the other one.
Registry registry_that_loses_contacts() {
  const Registry standard = Registry::standard();
  Registry registry;
  const auto add = [&]<class Stage>(const std::vector<StageDescriptor<Stage>>& stages) {
    for (StageDescriptor<Stage> stage : stages) {
      if constexpr (std::is_same_v<Stage, NarrowPhase>)
        if (stage.name == "inclusion")
          stage.make = [make = stage.make, made = std::make_shared<int>(0)](const OptionValues& values) {
            return std::unique_ptr<NarrowPhase>(std::make_unique<MadeUpNarrowPhase>(make(values), (*made)++ % 2 == 1));
          };
      registry.add(std::move(stage));
    }
  };
  add(standard.stages<BroadPhase>());
  add(standard.stages<ElementCulling>());
  add(standard.stages<Assignment>());
  add(standard.stages<OrphanSource>());
  add(standard.stages<Flood>());
  add(standard.stages<FeatureFilter>());
  add(standard.stages<NarrowPhase>());
  for (const PipelineSpec& pipeline : standard.pipelines()) registry.add_pipeline(pipeline);
  return registry;
}

class SubstepsExperiment : public testing::Test {
 protected:
  SubstepsExperiment() : file_(folder_ / "builtin.vtkhdf") {
    write_scene(*make_scene("builtin", {{"elements", "500"}, {"frames", "9"}}), file_);
  }

  PlanContext context(const Registry& registry, const std::string& scene) const {
    return {registry, false, {}, {}, [this, scene](const std::string& name) {
              return name == scene ? std::optional<std::string>(file_) : std::nullopt;
            }};
  }

  const ScratchFolder folder_;
  const std::string file_;
  const Registry registry_ = Registry::standard();
};

TEST_F(SubstepsExperiment, RowsTablesAndSummary) {
  PlanContext with_progress = context(registry_, "octopi-quick");
  std::size_t calls = 0;
  with_progress.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(std::pair(done, total), std::pair(std::size_t{0}, std::size_t{1}));
    ++calls;
  };
  const json record = {{"rows", made_rows(substeps_rows, with_progress)}};
  // 1 and 100 substeps of two motions and 10 of eight in three rounds, and at most 20 of the motion before them, all of
  // it twice.
  ASSERT_EQ(record.at("rows").size(), 3u * (2 + 8 + 2));
  EXPECT_EQ(calls, (1u * 2 + 10 * 8 + 100 * 2 + (1 + 10 + 20)) * 3 * 2);
  double reused = 0;
  for (const json& row : record.at("rows")) {
    expect_described(row, "substeps_row");
    EXPECT_EQ(row.at("scene"), "octopi");
    EXPECT_EQ(row.at("threads"), 1);
    EXPECT_EQ(row.at("fresh_substeps"), row.at("substeps"));
    int listed = 0;
    for (const char* with_list : {"reused_steps", "refreshed_steps", "list_steps"})
      listed += row.at(with_list).get<int>();
    EXPECT_LE(listed, row.at("substeps").get<int>());
    for (const char* positive :
         {"elements", "separation", "fresh_s", "list_s", "contacts", "fresh_bytes", "list_bytes"})
      EXPECT_GT(row.at(positive).get<double>(), 0) << positive;
    reused += row.at("reused_steps").get<double>();
  }
  EXPECT_GT(reused, 0) << "the scene shows nothing: no list is used";

  const json summary = substeps_summary(record);
  constexpr int kSubsteps[] = {1, 10, 100};
  ASSERT_EQ(summary.size(), std::size(kSubsteps));
  for (std::size_t i = 0; i < summary.size(); ++i) {
    const json& one = summary[i];
    expect_described(one, "substeps_summary");
    EXPECT_EQ(one.at("scene"), "octopi");
    EXPECT_EQ(one.at("substeps"), kSubsteps[i]);
    EXPECT_EQ(one.at("steps"), kSubsteps[i] == 10 ? 8 : 2);
    EXPECT_DOUBLE_EQ(one.at("separation").get<double>(), summary[0].at("separation").get<double>());
    for (const std::string key : {"fresh_ms", "list_ms", "speedup"}) {
      EXPECT_GT(one.at(key + "_min").get<double>(), 0);
      EXPECT_LE(one.at(key + "_min").get<double>(), one.at(key).get<double>());
      EXPECT_LE(one.at(key).get<double>(), one.at(key + "_max").get<double>());
    }
  }
  for (const TitledTable& table : substeps_tables(record)) EXPECT_EQ(table.table.rows().size(), 1u + summary.size());
}

/// The summary of made-up rows, so that each number is known.
TEST_F(SubstepsExperiment, TheSummaryHasMediansAndExtremesOfTheRounds) {
  json rows = json::array();
  for (int round = 0; round < 3; ++round)
    for (int motion = 4; motion < 6; ++motion)
      rows.push_back({{"scene", "octopi"},
                      {"substeps", 10},
                      {"step", motion},
                      {"window", 4},
                      {"round", round},
                      {"threads", 1},
                      {"elements", 100},
                      {"separation", 0.5},
                      {"fresh_s", 0.010 + 0.002 * round},
                      {"list_s", motion == 4 ? 0.001 : 0.003},
                      {"making_s", 0.0005},
                      {"refreshing_s", 0.0002},
                      {"comparing_s", 0.0001},
                      {"fresh_substeps", 10},
                      {"reused_steps", 5},
                      {"refreshed_steps", 1},
                      {"list_steps", 2},
                      {"list_tests", 800},
                      {"contacts", 7},
                      {"fresh_bytes", 1000},
                      {"list_bytes", 3000}});
  const json summary = substeps_summary({{"rows", rows}});
  ASSERT_EQ(summary.size(), 1u);
  const auto expect = [&](const char* key, double value) {
    EXPECT_NEAR(summary[0].at(key).get<double>(), value, 1e-9) << key;
  };
  expect("fresh_ms", 12), expect("fresh_ms_min", 10), expect("fresh_ms_max", 14);
  expect("list_ms", 2), expect("list_ms_min", 2), expect("list_ms_max", 2);
  expect("speedup", 6), expect("speedup_min", 5), expect("speedup_max", 7);
  expect("reused_share", 0.5), expect("refreshed_share", 0.1), expect("list_share", 0.2), expect("fresh_share", 0.2);
  expect("list_tests", 100), expect("lists", 2), expect("making_ms", 0.5), expect("comparing_ms", 0.1);
  expect("refreshing_ms", 0.2), expect("fresh_substeps", 10);
  expect("contacts", 7), expect("fresh_bytes", 1000), expect("list_bytes", 3000);
}

TEST_F(SubstepsExperiment, OtherContactsAreAnError) {
  const Registry registry = registry_that_loses_contacts();
  try {
    made_rows(substeps_rows, context(registry, "octopi-quick"));
    FAIL() << "a list that loses contacts went unnoticed";
  } catch (const Error& error) {
    const std::string text = error.what();
    for (const char* part : {"octopi", ", step ", "substep 0 of 1,", "without candidate lists", "not the same"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST_F(SubstepsExperiment, AFileOfOneMotionIsItsOwnWarmUp) {
  write_scene(*make_scene("builtin", {{"elements", "150"}, {"frames", "2"}}), file_);
  const std::vector<json> rows = made_rows(substeps_rows, context(registry_, "cloth-ball"));
  ASSERT_EQ(rows.size(), 3u * 3);
  for (const json& row : rows) EXPECT_EQ(row.at("step"), 0);
}

/// What was measured before an interruption is not measured again.
TEST_F(SubstepsExperiment, GoesOnAfterAnInterruption) {
  write_scene(*make_scene("builtin", {{"elements", "150"}, {"frames", "2"}}), file_);
  RecordFile record(folder_ / ".", "substeps", json::object());
  PlanContext stopping = context(registry_, "cloth-ball");
  int calls = 0;
  stopping.progress = [&](std::size_t, std::size_t) {
    if (++calls == 30) throw Error("stopped");
  };
  EXPECT_THROW(substeps_rows(stopping, record), Error);
  const std::vector<json> before = record.rows();
  ASSERT_GT(before.size(), 2u);
  ASSERT_LT(before.size(), 9u);
  substeps_rows(context(registry_, "cloth-ball"), record);
  ASSERT_EQ(record.rows().size(), 9u);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), record.rows().begin()));
}

TEST_F(SubstepsExperiment, ThePlanNamesTheInputs) {
  const ExperimentPlan plan = substeps_plan(context(registry_, "cloth-ball"));
  EXPECT_EQ(plan.rounds, 3);
  EXPECT_EQ(measured_runs(plan), 0u) << "the rows are made by substeps_rows() alone";
  ASSERT_EQ(provenance(plan, SerialExecutor()).at("inputs").size(), 1u);
}

TEST_F(SubstepsExperiment, NoSceneIsAnError) {
  EXPECT_THROW(made_rows(substeps_rows, context(registry_, "none")), ConfigError);
  EXPECT_TRUE(substeps_plan(context(registry_, "none")).runs.empty());
}

}  // namespace
}  // namespace volccd::test
