// Query motion in experiments: a sequence with stored queries is measured on them, with their separation.
#include <map>

#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/tables/table1.hpp>
#include <volccd/io/sequence/writer.hpp>

#include "experiments/described_keys.hpp"
#include "experiments/harness/harness_fixture.hpp"
#include "support/one_step.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

constexpr double kSeparation = 0.02;

/// The built-in sequence of the fixture. Its queries are the motions to the frames, half as long again.
class QueryMotion : public Harness {
 protected:
  QueryMotion() : with_queries_(folder_ / "queries.vtkhdf") {
    SequenceReader reader(file_);
    SequenceWriter writer(with_queries_,
                          std::vector<std::int64_t>(reader.point_ids().begin(), reader.point_ids().end()));
    std::vector<Vec3> start, x, end;
    SequenceCells cells;
    for (int k = 0; k < reader.frame_count(); ++k) {
      reader.read_points(std::max(k - 1, 0), start);
      reader.read_points(k, x);
      reader.read_cells(k, cells);
      end = x;
      for (std::size_t v = 0; v < x.size(); ++v) end[v] += 0.5 * (x[v] - start[v]);
      FrameFields fields;
      fields.query_start = start, fields.query_end = end, fields.query_separation = kSeparation;
      writer.write_frame(reader.time(k), x, cells, fields);
    }
    writer.finish();
  }

  ExperimentPlan table1(const std::string& file, bool full) const {
    return table1_plan({registry_, full, {}, {}, [&](const std::string& name) {
                          return name.starts_with("octopi") ? std::optional(file) : std::nullopt;
                        }});
  }
  static std::size_t on_queries(const ExperimentPlan& plan) {
    return static_cast<std::size_t>(std::count_if(plan.runs.begin(), plan.runs.end(), [](const SceneRun& run) {
      return run.config.motion == MotionModel::query;
    }));
  }

  const std::string with_queries_;
};

TEST_F(QueryMotion, IsInTheFullTable1OfFilesThatHaveQueries) {
  EXPECT_EQ(on_queries(table1(with_queries_, true)), 1u) << "table c alone: cubic and provot take no separation";
  EXPECT_EQ(on_queries(table1(with_queries_, false)), 0u);
  EXPECT_EQ(on_queries(table1(file_, true)), 0u) << "a file without queries";
}

TEST_F(QueryMotion, RowsHaveTheContactsWithinTheSeparation) {
  ExperimentPlan plan = table1(with_queries_, true);
  std::erase_if(plan.runs, [](const SceneRun& run) {
    return run.config.motion == MotionModel::tentative || run.config.edge_set == EdgeSet::polytope ||
           run.entrants.front().table != "c";
  });
  ASSERT_EQ(plan.runs.size(), 2u) << "linear and query";
  for (SceneRun& run : plan.runs) run.windows = {{3, 1}}, run.rounds = 1;
  const std::vector<json> rows = rows_of(plan, 1, "table1");

  SequenceReader reader(with_queries_);
  SequenceStepper stepper(reader, plan.runs[1].config);
  stepper.go_to(3);
  const StepResult result =
      test::run_step({stepper.topology(), stepper.motion(), test::kAllObjects, kSeparation}, {}, "NavCCD");
  const StepResult without = test::run_step({stepper.topology(), stepper.motion(), test::kAllObjects, 0}, {}, "NavCCD");
  std::size_t linear = 0, query = 0;
  double without_ms = 0;
  const std::uint64_t touching = touching_pair_count(stepper.topology(), result.contacts),
                      touching_without = touching_pair_count(stepper.topology(), without.contacts);
  ASSERT_NE(touching, touching_without) << "the scene shows nothing";
  for (const json& row : rows) {
    if (row.at("motion_model") == "linear") {
      EXPECT_EQ(row.at("separation"), 0);
      linear += row.at("contacts").get<std::size_t>();
      continue;
    }
    if (row.at("variant") == "without separation") {
      EXPECT_EQ(row.at("separation"), 0);
      EXPECT_EQ(row.at("contacts"), without.contacts.size());
      EXPECT_EQ(row.at("touching_pairs"), touching_without);
      without_ms = 1e3 * (row.at("seconds").get<double>() + row.at("topology_seconds").get<double>());
      continue;
    }
    EXPECT_EQ(row.at("separation"), kSeparation);
    EXPECT_EQ(row.at("contacts"), result.contacts.size()) << row.at("pipeline");
    EXPECT_EQ(row.at("touching_pairs"), touching) << row.at("pipeline");
    query += result.contacts.size();
  }
  EXPECT_GT(query, linear) << "the scene shows nothing";
  EXPECT_TRUE(contact_differences(registry_, plan, rows).empty());

  const json record = {{"rows", rows}, {"provenance", {{"setting", "full"}, {"commit", "c"}}}};
  const std::string text = render(table1_tables(record), TableFormat::text);
  EXPECT_NE(text.find("query motion"), std::string::npos);
  EXPECT_NE(text.find("with its separation"), std::string::npos);
  const json summary = table1_summary(record);
  ASSERT_EQ(summary.size(), 2u);
  EXPECT_EQ(summary[1].at("motion_model"), "query");
  std::map<std::string, double> tests;
  for (const json& row : rows)
    if (row.at("pipeline") == "NavCCD" && row.at("motion_model") == "linear")
      tests[row.at("variant")] = row.at("vf_tests").get<double>() + row.at("ee_tests").get<double>();
  EXPECT_EQ(tests.size(), 3u) << "alone, without adjacent pairs, filtered";
  EXPECT_LT(tests.at("feature-filter=feature-kdop,coplanarity"), tests.at(""));
  EXPECT_GT(summary[0].at("speedup_navccd_filtered_plus").get<double>(), 0);
  EXPECT_NEAR(summary[1].at("separation_costs_plus").get<double>(),
              summary[1].at("volccd_plus_ms").get<double>() / without_ms, 1e-9)
      << "with over without";
  for (const char* key : {"hashccd_ms", "speedup_hashccd_plus", "navccd_filtered_ms"})
    EXPECT_FALSE(summary[1].contains(key)) << key << ": fewer pipelines run on queries";
  expect_described(summary[1], "table1_summary");
}

/// The summary's keys are those that docs/record.schema.json promises to scripts.
TEST_F(QueryMotion, SummaryOfTable1HasTheDocumentedKeys) {
  ExperimentPlan plan = table1(file_, false);
  for (SceneRun& run : plan.runs) run.windows = {{3, 1}};
  const json summary = table1_summary({{"rows", rows_of(plan, 1, "table1")}});
  ASSERT_EQ(summary.size(), 3u) << "a, b and c";
  for (const json& line : summary) {
    expect_described(line, "table1_summary");
    for (const char* key : {"scene", "navccd_ms", "hashccd_ms", "volccd_ms", "speedup_navccd", "speedup_hashccd",
                            "culling_ratio_percent"})
      EXPECT_TRUE(line.contains(key)) << key << " of table " << line.at("table");
    EXPECT_EQ(line.contains("volccd_plus_ms"), line.at("table") == "c");
    EXPECT_NEAR(line.at("speedup_navccd").get<double>() * line.at("volccd_ms").get<double>(),
                line.at("navccd_ms").get<double>(), 1e-9);
  }
}

}  // namespace
}  // namespace volccd::test
