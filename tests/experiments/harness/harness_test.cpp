// The harness: what it measures, that edits are repeated in every round, and that counts do not depend on the numbers
// of rounds and threads.
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/harness/subdivide.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/inversion_table.hpp>
#include <volccd/experiments/tables/operation_table.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "experiments/harness/harness_fixture.hpp"
#include "experiments/made_rows.hpp"
#include "io/sequence/sequences.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

TEST(SampledWindows, AreSpreadEvenlyAndHaveAMotionBefore) {
  const std::vector<StepWindow> all = sampled_windows(5, 3, 2);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].count, 5);
  for (const int steps : {9, 10, 64, 96}) {
    const std::vector<StepWindow> some = sampled_windows(steps, 4, 2);
    ASSERT_EQ(some.size(), 4u) << steps;
    int last = 0;
    for (const StepWindow& window : some) {
      EXPECT_GE(window.first, std::max(1, last)) << steps;
      last = window.first + window.count;
    }
    EXPECT_LE(last, steps);
    EXPECT_GE(last, steps - steps / 4 - 1) << "nothing of the last quarter";
  }
}

TEST(SampledWindows, HaveAnEditIfOneCanBeReached) {
  const std::vector<StepWindow> windows = {{5, 3}, {20, 3}, {35, 3}};
  const auto firsts = [&](const std::vector<int>& edits) {
    std::vector<int> result;
    for (const StepWindow& window : with_an_edit(windows, 40, edits)) result.push_back(window.first);
    return result;
  };
  EXPECT_EQ(firsts({}), (std::vector<int>{5, 20, 35}));
  EXPECT_EQ(firsts({1, 22, 30}), (std::vector<int>{5, 20, 35})) << "22 is in a window";
  EXPECT_EQ(firsts({1, 27}), (std::vector<int>{0 + 1, 20, 35})) << "the window of least distance";
  EXPECT_EQ(firsts({26}), (std::vector<int>{5, 25, 35}));
  EXPECT_EQ(firsts({39}), (std::vector<int>{5, 20, 37})) << "up to the last step";
  EXPECT_EQ(firsts({0}), (std::vector<int>{5, 20, 35})) << "step 0 is in no window";
  EXPECT_EQ(with_an_edit({{1, 2}, {3, 2}, {5, 2}}, 8, {7}).back().first, 6);
  EXPECT_EQ(with_an_edit({{0, 5}}, 5, {4}).front().first, 0) << "all steps";
}

/// Columns that do not contain times.
json counts_of(json row) {
  json counts;
  for (const auto& [name, value] : row.items())
    if (!name.ends_with("_s") && !name.ends_with("seconds") && name != "workspace_bytes" && name != "threads" &&
        name != "round")
      counts[name] = value;
  return counts;
}

TEST_F(Harness, ARowForEachMotionEntrantAndRound) {
  const std::vector<json> rows = rows_of(plan(2, {{1, 2}, {5, 1}}), 1, "a");
  EXPECT_EQ(rows.size(), 3u * 4u * 2u);
  std::set<std::string> keys;
  for (const json& row : rows) {
    keys.insert(row.at("pipeline").get<std::string>() + row.at("step").dump() + "/" + row.at("round").dump());
    EXPECT_GT(row.at("seconds").get<double>(), 0);
    EXPECT_GE(row.at("broad_phase_prepare_s").get<double>(), row.at("bounds_s").get<double>());
  }
  EXPECT_EQ(keys.size(), rows.size());
}

TEST_F(Harness, CountsRepeatForAnyNumberOfThreadsAndRounds) {
  const ExperimentPlan three = plan(3, {{2, 2}});
  const std::vector<json> once = rows_of(plan(1, {{2, 2}}), 1, "once");
  std::map<std::string, json> expected;
  const auto key = [](const json& row) { return row.at("pipeline").get<std::string>() + row.at("step").dump(); };
  for (const json& row : once) expected[key(row)] = counts_of(row);
  for (const unsigned threads : {1u, 3u})
    for (const json& row : rows_of(three, threads, "t" + std::to_string(threads))) {
      EXPECT_EQ(counts_of(row), expected.at(key(row))) << key(row) << " round " << row.at("round");
    }
}

TEST_F(Harness, EveryRoundRepeatsTheEdit) {
  int edited = 0;
  for (int first = 1; first < 8 && edited == 0; ++first) {
    const std::vector<json> rows = rows_of(plan(3, {{first, 1}}), 1, "e" + std::to_string(first));
    for (const json& row : rows) edited += row.at("topology_seconds").get<double>() > 0;
    EXPECT_TRUE(edited == 0 || edited == static_cast<int>(rows.size())) << "some rounds have an edit, and others none";
  }
  EXPECT_GT(edited, 0) << "the scene shows nothing: no element erodes";
}

/// Blocks that move and lose an element between steps 3 and 4.
void write_loss(const std::string& file) {
  const Shape shape = block(ElementType::tetrahedron, 2, 1, 1);
  Sequence sequence;
  for (std::size_t v = 0; v < shape.positions.size(); ++v) sequence.point_ids.push_back(static_cast<std::int64_t>(v));
  for (int k = 0; k < 8; ++k) {
    Sequence::Step step{0.1 * k, shape.positions, {}, {}, {}};
    for (Vec3& x : step.points) x += 0.1 * k * Vec3::UnitX();
    step.velocity.assign(shape.positions.size(), Vec3::UnitX());
    for (std::size_t o = k < 4 ? 0 : 1; o < shape.elements.size(); ++o) step.cells.add(shape.elements[o]);
    sequence.steps.push_back(std::move(step));
  }
  sequence.write(file);
}

/// Motion k uses the cells of step k + 1, or of step k if it is tentative.
TEST_F(Harness, RoundsRunForwardFromTheStepBeforeTheWindow) {
  const std::string file = folder_ / "loss.vtkhdf";
  write_loss(file);
  for (const MotionModel model : {MotionModel::linear, MotionModel::tentative})
    for (int first = 1; first < 6; ++first) {
      SCOPED_TRACE(testing::Message() << name_of(model) << " motion, window of 2 from " << first);
      ExperimentPlan two = plan(2, {{first, 2}});
      two.runs[0].file = file;
      two.runs[0].config.motion = model;
      RecordFile record(folder_ / "", fmt::format("loss-{}-{}", name_of(model), first), {{"a", 1}});
      SerialExecutor serial;
      std::size_t runs = 0;
      run_experiment(registry_, two, serial, record, [&](std::size_t, std::size_t) { ++runs; });
      const std::size_t round = 4u * (1 + 2);  // of 4 pipelines: a step before and two steps
      EXPECT_GE(runs, 2 * round);
      EXPECT_EQ(runs % round, 0u) << "a stalled round is measured again, which may happen beside other work";
      const int edited = model == MotionModel::tentative ? 4 : 3;
      for (const json& row : record.rows()) {
        EXPECT_EQ(row.at("topology_seconds").get<double>() > 0, row.at("step") == edited)
            << "step " << row.at("step") << ", round " << row.at("round");
        EXPECT_GT(row.at("first_seconds").get<double>(), 0);
      }
    }
}

/// Drops nothing, and is slow the fourth time.
class Stalls final : public FeatureFilter {
 public:
  void prepare(const Step&, StageState&, Executor&) const override {
    if (++calls_ == 4) std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  void run(const Step&, StageState&, unsigned, const TestBlock&, std::span<std::uint8_t>) const override {}

 private:
  mutable int calls_ = 0;
};

TEST_F(Harness, AStalledStepIsMeasuredAgain) {
  Registry registry = all_stages();
  StageDescriptor<FeatureFilter> stalls;
  stalls.name = "stalls";
  stalls.make = [](const OptionValues&) { return std::make_unique<Stalls>(); };
  registry.add(stalls);
  SceneRun run{"block", file_, {}, {{2, 1}}, {entrant(registry, "", "NavCCD", {"feature-filter=stalls"})}};
  RecordFile record(folder_ / "", "stalls", {{"a", 1}});
  SerialExecutor serial;
  run_experiment(registry, {"test", "quick", 2, {run}}, serial, record);
  ASSERT_EQ(record.rows().size(), 2u);
  for (const json& row : record.rows()) {
    const bool stalled = row.at("round") == 1;  // each round has a step before the one that is measured
    EXPECT_EQ(row.at("stalled_seconds").get<double>() >= 0.3, stalled);
    EXPECT_LT(row.at("seconds").get<double>(), 0.3);
  }
}

TEST_F(Harness, GoesOnWhereItWasStopped) {
  const ExperimentPlan two = plan(1, {{1, 1}, {4, 1}});
  SerialExecutor serial;
  {
    RecordFile record(folder_ / "", "r", {{"a", 1}});
    EXPECT_THROW(run_experiment(registry_, two, serial, record,
                                [](std::size_t done, std::size_t) {
                                  if (done >= 4) throw Error("stop");
                                }),
                 Error);
    EXPECT_EQ(record.rows().size(), 4u);
  }
  RecordFile record(folder_ / "", "r", {{"a", 1}});
  EXPECT_EQ(record.resumed(), 1u);
  std::size_t min = 100;
  run_experiment(registry_, two, serial, record, [&](std::size_t done, std::size_t) { min = std::min(min, done); });
  EXPECT_EQ(min, 4u) << "the first window ran again";
  EXPECT_EQ(record.rows().size(), 8u);
}

TEST_F(Harness, ProcessesDivideTheRounds) {
  ExperimentPlan two = plan(3, {{1, 1}, {4, 1}});
  two.processes = 2;
  SerialExecutor serial;
  std::map<int, std::set<int>> rounds;  // by process
  for (const bool complete : {false, true, true}) {
    RecordFile record(folder_ / "", "r", {{"a", 1}});
    EXPECT_EQ(run_experiment(registry_, two, serial, record), complete);
    EXPECT_EQ(record.rows().size(), complete ? 24u : 8u) << "of 4 pipelines and 2 steps: three rounds, and one";
    for (const json& row : record.rows()) rounds[row.at("process")].insert(row.at("round").get<int>());
  }
  EXPECT_EQ(rounds, (std::map<int, std::set<int>>{{0, {0}}, {1, {1, 2}}}));
}

TEST_F(Harness, ARecordIsCompleteForItsOwnIdentityAlone) {
  const ExperimentPlan one = plan(1, {{1, 1}});
  SerialExecutor serial;
  const json facts = provenance(one, serial), identity = identity_of(facts);
  RecordFile record(folder_ / "", "r", identity);
  EXPECT_FALSE(complete_record(record.file(), identity)) << "there is none";
  run_experiment(registry_, one, serial, record);
  EXPECT_FALSE(complete_record(record.file(), identity)) << "not finished";
  record.finish(facts, json::array());
  ASSERT_TRUE(complete_record(record.file(), identity));
  EXPECT_EQ(complete_record(record.file(), identity)->at("rows").size(), 4u);
  EXPECT_FALSE(complete_record(record.file(), identity_of(provenance(plan(2, {{1, 1}}), serial)))) << "other rounds";
  for (const char* fact : {"commit", "program_fnv1a", "cpu", "inputs"}) {
    json other = identity;
    other[fact] = "another";
    EXPECT_FALSE(complete_record(record.file(), other)) << fact;
  }
  write_text_file(record.file(), "{\"rows\": [");
  EXPECT_FALSE(complete_record(record.file(), identity)) << "not JSON";
}

TEST_F(Harness, AdjacentPairsAreThoseThatThePipelineCounts) {
  SequenceReader reader(file_);
  SequenceStepper stepper(reader);
  stepper.go_to(3);
  const ObjectFilter everything;
  SerialExecutor serial;
  const Pipeline pipeline(registry_, registry_.pipeline("NavCCD"));
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  pipeline.run({stepper.topology(), stepper.motion(), everything}, workspace, serial, result);
  EXPECT_EQ(adjacent_pair_count(stepper.topology()), result.statistics.adjacent_pairs);
  Request without;
  without.count_adjacent = false;
  pipeline.run({stepper.topology(), stepper.motion(), everything}, workspace, serial, result, without);
  EXPECT_EQ(result.statistics.adjacent_pairs, 0u);
}

TEST_F(Harness, TablesAreMadeOfTheRecordAlone) {
  const ExperimentKind& kind = experiment_kinds().at(0);
  const json record = {{"rows", rows_of(plan(2, {{1, 3}}), 1, "a")},
                       {"provenance", {{"setting", "quick"}, {"commit", "c"}}}};
  for (const TableFormat format : {TableFormat::text, TableFormat::markdown, TableFormat::csv, TableFormat::latex}) {
    const std::string table = render(kind.tables(record), format);
    EXPECT_NE(table.find("VolCCD+"), std::string::npos);
    EXPECT_EQ(table, render(kind.tables(json::parse(record.dump())), format)) << "not the same from the file";
  }
}

TEST_F(Harness, EveryPlanHasScenesAndPipelinesThatCanBeMade) {
  for (const bool full : {false, true}) {
    const PlanContext context{registry_, full, {}, {}, [&](const std::string&) { return std::optional(file_); }};
    for (const ExperimentKind& kind : experiment_kinds()) {
      const ExperimentPlan plan = kind.plan(context);
      EXPECT_FALSE(plan.runs.empty()) << kind.name;
      const json inputs = provenance(plan, SerialExecutor()).at("inputs");
      ASSERT_EQ(inputs.size(), 1u) << kind.name;
      EXPECT_EQ(inputs[0].at("fnv1a"), file_hash(file_)) << kind.name;
      EXPECT_EQ(measured_runs(plan) > 0, kind.rows == nullptr) << kind.name << ": else it names its inputs only";
      for (const SceneRun& run : plan.runs)
        for (const Entrant& entrant : run.entrants) EXPECT_NO_THROW(Pipeline(registry_, entrant.spec)) << kind.name;
    }
  }
}

TEST_F(Harness, ASweepRunsEachValueOfASetting) {
  const PlanContext context{
      registry_, false, {"VolCCD"}, {"csat.axis=face,centroid", "feature-filter=none"}, [&](const std::string&) {
        return std::optional(file_);
      }};
  const ExperimentKind& ablation = experiment_kinds().at(4);
  ASSERT_STREQ(ablation.name, "ablation");
  std::vector<std::string> variants;
  const ExperimentPlan plan = ablation.plan(context);
  for (const Entrant& entrant : plan.runs.at(0).entrants) variants.push_back(entrant.variant);
  EXPECT_EQ(variants, (std::vector<std::string>{"", "csat.axis=face", "csat.axis=centroid", "feature-filter=none"}));
}

TEST_F(Harness, OperationsAreCountedOnAScene) {
  const PlanContext context{registry_, false, {}, {}, [&](const std::string&) { return std::optional(file_); }};
  const std::vector<json> rows = made_rows(operation_rows, context);
  EXPECT_GE(rows.size(), 8u);
  EXPECT_NE(render(operation_tables({{"rows", rows}}), TableFormat::text).find("217"), std::string::npos)
      << "the paper's";
  EXPECT_EQ(operation_tables({{"rows", rows}}).size(), 3u) << "those of coplanarity, and of OBBs and k-DOPs, too";
  std::vector<json> earlier;
  for (const json& row : rows)
    if (!row.at("operation").get<std::string>().starts_with("coplanarity")) earlier.push_back(row);
  EXPECT_EQ(operation_tables({{"rows", earlier}}).size(), 2u) << "a record without coplanarity";
  EXPECT_EQ(operation_plan(context).runs.size(), 1u);
}

TEST_F(Harness, InversionsAreCountedOnAllMotionsOfTheScenes) {
  const PlanContext context{registry_, false, {}, {}, [&](const std::string& name) {
                              return name == "bullet-quick" ? std::optional(file_) : std::nullopt;
                            }};
  ASSERT_EQ(inversion_plan(context).runs.size(), 1u);
  const std::vector<json> rows = made_rows(inversion_rows, context);
  const SequenceReader reader(file_);
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(reader.frame_count() - 1) * (reader.has_velocity() ? 2 : 1));
  std::uint64_t examined = 0;
  for (const json& row : rows) {
    EXPECT_EQ(row.at("scene"), "bullet");
    examined += row.at("examined").get<std::uint64_t>();
    EXPECT_EQ(row.at("intra").get<std::uint64_t>(),
              row.at("intra_at_start").get<std::uint64_t>() + row.at("in_inverted").get<std::uint64_t>() +
                  row.at("at_inverted").get<std::uint64_t>() + row.at("missed").get<std::uint64_t>());
  }
  EXPECT_GT(examined, 0u);
  const auto cells = inversion_tables({{"rows", rows}}).front().table.rows();
  EXPECT_EQ(cells.size(), reader.has_velocity() ? 3u : 2u);
  EXPECT_EQ(cells[1].at(3), std::to_string(reader.frame_count() - 1)) << "motions";
}

TEST(Refine, KeepsTheMotionAndTheVolumeOfEveryType) {
  for (const ElementType type : {ElementType::triangle, ElementType::quad, ElementType::tetrahedron, ElementType::wedge,
                                 ElementType::hexahedron}) {
    const Shape shape = block(type, 2, 2, 2);
    const Topology topology(shape.mesh());
    std::vector<Vec3> moved = shape.positions;
    for (Vec3& p : moved) p += Vec3(0.5, 0.25, 1);
    const RefinedStep fine = refine(topology, Motion::linear(shape.positions, moved), 2);
    const Index parts = is_shell(type) ? 4 : 8;
    EXPECT_EQ(fine.mesh.element_count(), shape.elements.size() * parts * parts);
    for (Index v = 0; v < fine.motion.vertex_count(); ++v)
      EXPECT_TRUE(fine.motion.point(v, 1).isApprox(fine.motion.point(v, 0) + Vec3(0.5, 0.25, 1)));
    // Neighbours share their new vertices: a block divided twice has as many vertices as one with eight cells along
    // each edge.
    if (type != ElementType::tetrahedron) {
      EXPECT_EQ(fine.mesh.vertex_count(), block(type, 8, 8, 8).positions.size()) << to_string(type);
    }
    const Topology refined(fine.mesh);
    Index boundary = 0;
    for (Index f = 0; f < refined.features().triangle_slots(); ++f)
      boundary += refined.features().triangle_elements(f).size() == 1;
    Index coarse = 0;
    for (Index f = 0; f < topology.features().triangle_slots(); ++f)
      coarse += topology.features().triangle_elements(f).size() == 1;
    EXPECT_EQ(boundary, coarse * 16) << to_string(type) << ": cracks between the parts of neighbours";
  }
  for (const ElementType type : {ElementType::wedge, ElementType::hexahedron}) {
    const Shape shape = block(type, 2, 2, 1);
    const RefinedStep fine =
        refine(Topology(shape.mesh()), Motion::linear(shape.positions, shape.positions), 1, Division::in_plane);
    EXPECT_EQ(fine.mesh.element_count(), shape.elements.size() * 4);
    EXPECT_EQ(fine.mesh.vertex_count(), block(type, 4, 4, 1).positions.size()) << to_string(type);
  }
  EXPECT_THROW(refine(Topology(block(ElementType::pyramid, 1, 1, 1).mesh()), Motion(9, 2), 1), ConfigError);
}

}  // namespace
}  // namespace volccd::test
