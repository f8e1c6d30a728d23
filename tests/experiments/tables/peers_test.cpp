// The experiment `peers` on a small scene: the contents of its rows, and an error if broad phases disagree.
#include <volccd/experiments/tables/peers.hpp>

#include <gtest/gtest.h>

#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/harness/run.hpp>
#include <volccd/experiments/scenes/scene.hpp>

#include "experiments/made_rows.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

/// Replaces a peer: gives the pairs of `kdop-bvh`, or only the first batch of them.
class MadeUpPeer final : public BroadPhase {
 public:
  explicit MadeUpPeer(bool loses) : loses_(loses) {
    KdopBvh::Config boxes;
    boxes.k = 6;
    tree_ = std::make_unique<KdopBvh>(boxes);
  }

  std::unique_ptr<StageState> make_state() const override { return tree_->make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    tree_->prepare(step, state, executor);
  }
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override {
    return tree_->blocks(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override {
    const std::size_t before = work.pairs.size();
    tree_->run(step, state, worker, block, work);
    if (loses_ && work.pairs.size() > before) work.pairs.pop_back();
  }

 private:
  bool loses_;
  std::unique_ptr<KdopBvh> tree_;
};

class PeersExperiment : public testing::Test {
 protected:
  PeersExperiment() : file_(folder_ / "builtin.vtkhdf") {
    write_scene(*make_scene("builtin", {{"elements", "200"}, {"frames", "9"}}), file_);
  }

  void add_peer(bool loses) {
    registry_.add(StageDescriptor<BroadPhase>{
        "cgal-box-intersection",
        "made up",
        Guarantee::conservative,
        {},
        [loses](const OptionValues&) -> std::unique_ptr<BroadPhase> { return std::make_unique<MadeUpPeer>(loses); }});
  }
  PlanContext context(const std::string& scene) const {
    return {registry_, false, {}, {}, [this, scene](const std::string& name) {
              return name == scene ? std::optional<std::string>(file_) : std::nullopt;
            }};
  }

  const ScratchFolder folder_;
  const std::string file_;
  Registry registry_ = Registry::standard();
};

TEST_F(PeersExperiment, RowsAndSummary) {
  add_peer(false);
  const json record = {{"rows", made_rows(peers_rows, context("octopi-quick"))}};
  // Four broad phases of the library and one peer, on two motions, three rounds.
  ASSERT_EQ(record.at("rows").size(), 5u * 2 * 3);
  for (const json& row : record.at("rows")) {
    EXPECT_EQ(row.at("scene"), "octopi");
    EXPECT_EQ(row.at("volume"), true);
    EXPECT_EQ(row.at("threads"), 1);
    for (const char* positive : {"elements", "build_ms", "query_ms", "pairs", "pairs_per_second", "bytes"})
      EXPECT_GT(row.at(positive).get<double>(), 0) << positive;
  }
  const json summary = peers_summary(record);
  ASSERT_EQ(summary.size(), 5u);
  for (const json& row : summary) {
    const bool peer = row.at("broadphase") == "cgal-box-intersection";
    EXPECT_EQ(row.at("peer"), peer);
    if (peer)
      EXPECT_EQ(row.at("speedup_fastest_peer"), 1.0);
    else
      EXPECT_GT(row.at("speedup_fastest_peer").get<double>(), 0);
  }
  EXPECT_EQ(summary[0].at("broadphase"), "kdop-bvh k=6");
  EXPECT_EQ(summary[0].at("pairs"), summary[1].at("pairs"));
  EXPECT_EQ(peers_tables(record).size(), 1u);
}

TEST_F(PeersExperiment, AFileOfOneMotionHasAMotionBeforeIt) {
  write_scene(*make_scene("builtin", {{"elements", "200"}, {"frames", "2"}}), file_);
  const std::vector<json> rows = made_rows(peers_rows, context("cloth-ball"));
  ASSERT_EQ(rows.size(), 4u * 3);
  for (const json& row : rows) EXPECT_EQ(row.at("step"), 0);
  const json summary = peers_summary({{"rows", rows}});
  for (const json& row : summary) EXPECT_TRUE(row.at("speedup_fastest_peer").is_null()) << "there is no peer";
}

TEST_F(PeersExperiment, DifferentCountsAreAnError) {
  add_peer(true);
  try {
    made_rows(peers_rows, context("octopi-quick"));
    FAIL() << "a broad phase that loses pairs went unnoticed";
  } catch (const Error& error) {
    const std::string text = error.what();
    for (const char* part : {"octopi", "step 2", "kdop-bvh k=6", "cgal-box-intersection"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST_F(PeersExperiment, ThePlanNamesTheInputs) {
  const ExperimentPlan plan = peers_plan(context("cloth-ball"));
  EXPECT_EQ(plan.rounds, 3);
  EXPECT_EQ(measured_runs(plan), 0u) << "the rows are made by peers_rows() alone";
  const json inputs = provenance(plan, SerialExecutor()).at("inputs");
  ASSERT_EQ(inputs.size(), 1u);
  EXPECT_EQ(inputs[0], (json{{"scene", "cloth-ball"}, {"file", "builtin.vtkhdf"}, {"fnv1a", file_hash(file_)}}));
}

TEST_F(PeersExperiment, NoSceneIsAnError) {
  EXPECT_THROW(made_rows(peers_rows, context("none")), ConfigError);
  EXPECT_TRUE(peers_plan(context("none")).runs.empty());
}

}  // namespace
}  // namespace volccd::test
