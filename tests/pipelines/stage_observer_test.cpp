// An observer of a run receives what the statistics count.
#include <volccd/pipelines/stage_observer.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"

namespace volccd {
namespace {

using test::registry;
using test::Scene;

/// Adds up the pairs that the stages of a run process and keep, for each worker and stage.
class CountingObserver final : public StageObserver {
 public:
  struct Counts {
    std::uint64_t pairs = 0, pairs_kept = 0, tests = 0, tests_kept = 0;
    bool produces = false;
  };

  explicit CountingObserver(unsigned workers) : counts_(workers) {}

  void observe(std::size_t stage, unsigned worker, const Step& step, std::span<const ElementPair> pairs,
               std::span<const std::uint8_t> keep) override {
    for (const ElementPair pair : pairs) EXPECT_LT(std::max(pair.a, pair.b), step.mesh().element_slots());
    Counts& counts = counts_[worker][stage];
    add(counts, counts.pairs, counts.pairs_kept, pairs.size(), keep);
  }
  void observe(std::size_t stage, unsigned worker, const Step& step, FeatureKind kind,
               std::span<const FeaturePair> tests, std::span<const std::uint8_t> keep) override {
    for (const FeaturePair test : tests) EXPECT_TRUE(is_test(step.topology.features(), kind, test));
    Counts& counts = counts_[worker][stage];
    add(counts, counts.tests, counts.tests_kept, tests.size(), keep);
  }

  Counts of(std::size_t stage) const {
    Counts sum;
    for (const auto& worker : counts_) {
      const auto found = worker.find(stage);
      if (found == worker.end()) continue;
      sum.pairs += found->second.pairs, sum.pairs_kept += found->second.pairs_kept;
      sum.tests += found->second.tests, sum.tests_kept += found->second.tests_kept;
      sum.produces = sum.produces || found->second.produces;
    }
    return sum;
  }

 private:
  static void add(Counts& counts, std::uint64_t& all, std::uint64_t& kept, std::size_t size,
                  std::span<const std::uint8_t> keep) {
    EXPECT_TRUE(keep.empty() || keep.size() == size);
    counts.produces = counts.produces || (keep.empty() && size > 0);
    all += size;
    kept += keep.empty() ? size : static_cast<std::size_t>(std::count(keep.begin(), keep.end(), 1));
  }

  std::vector<std::map<std::size_t, Counts>> counts_;
};

void expect_observed(const StepResult& result, const CountingObserver& observer, const std::string& what) {
  const Statistics& all = result.statistics;
  for (std::size_t i = 0; i < all.stages.size(); ++i) {
    const StageStatistics& stage = all.stages[i];
    const std::string where = what + " " + stage.role + " " + stage.name;
    const CountingObserver::Counts counts = observer.of(i);
    if (stage.role == "flood" && counts.tests > 0) {
      EXPECT_EQ(all.orphan_tests, counts.tests) << where;
    }
    const bool on_pairs = stage.role == "broad-phase" || stage.role == "element-culling" || stage.role == "flood";
    if (stage.role != "flood") {
      EXPECT_EQ(0u, on_pairs ? counts.tests : counts.pairs) << where;
    }
    if (stage.role == "initial-overlaps") continue;
    EXPECT_EQ(stage.out, on_pairs ? counts.pairs_kept : counts.tests_kept) << where;
    const bool filters =
        stage.role == "element-culling" || stage.role == "feature-filter" || stage.role == "narrow-phase";
    EXPECT_FALSE(filters && counts.produces) << where;
    if (filters) {
      EXPECT_EQ(stage.in, on_pairs ? counts.pairs : counts.tests) << where;
    }
  }
}

/// All presets, and the flood without the limits above which it leaves a step to the other stages.
std::vector<PipelineSpec> observed_pipelines() {
  std::vector<PipelineSpec> specs(registry().pipelines().begin(), registry().pipelines().end());
  PipelineSpec flood = registry().pipeline("VolCCD+");
  flood.name = "unlimited flood";
  flood.flood->options = {{"max_boundary_fraction", "1"},
                          {"max_divided_fraction", "1"},
                          {"max_suspect_fraction", "1"},
                          {"max_pairs", "1e9"}};
  specs.push_back(flood);
  return specs;
}

/// Runs the scene without and with an observer, which must see what the statistics count, and change nothing.
class ObservedRuns {
 public:
  void add(const Scene& scene, const PipelineSpec& spec, unsigned threads) {
    const auto executor = make_thread_executor(threads);
    const Pipeline pipeline(registry(), spec);
    Workspace workspace = pipeline.make_workspace();
    const ObjectFilter filter;
    const Step step{scene.topology, scene.motion, filter};
    StepResult expected, result;
    pipeline.run(step, workspace, *executor, expected);
    CountingObserver observer(executor->workers());
    Request request;
    request.observer = &observer;
    pipeline.run(step, workspace, *executor, result, request);
    const std::string what = scene.name + " " + spec.name;
    EXPECT_TRUE(compare_contacts(expected.contacts, result.contacts).empty()) << what;
    expect_observed(result, observer, what);
    for (std::size_t i = 0; i < result.statistics.stages.size(); ++i) {
      const CountingObserver::Counts counts = observer.of(i);
      const std::string& role = result.statistics.stages[i].role;
      dropped_[role] += counts.pairs - counts.pairs_kept + counts.tests - counts.tests_kept;
      given_[role] += counts.pairs_kept + counts.tests_kept;
    }
  }

  void expect_that_each_role_had_work() {
    for (const char* role : {"element-culling", "feature-filter", "narrow-phase"})
      EXPECT_GT(dropped_[role], 0u) << role;
    for (const char* role : {"broad-phase", "assignment", "orphans", "flood"}) EXPECT_GT(given_[role], 0u) << role;
  }

 private:
  std::map<std::string, std::uint64_t> dropped_, given_;  ///< by role, over all runs
};

Scene folded() { return test::colliding("folded", block(ElementType::tetrahedron, 4, 4, 2), 9, 0.45); }

TEST(StageObserver, SeesThePairsThatTheStatisticsCount) {
  std::vector<Scene> scenes = test::small_scenes(7, 0.3);
  scenes.push_back(folded());
  ObservedRuns runs;
  for (const Scene& scene : scenes)
    for (const PipelineSpec& spec : observed_pipelines()) runs.add(scene, spec, 1);
  runs.expect_that_each_role_had_work();
}

TEST(ThreadsStageObserver, SeesThePairsThatTheStatisticsCount) {
  const Scene scene = folded();
  ObservedRuns runs;
  for (const PipelineSpec& spec : observed_pipelines()) runs.add(scene, spec, 3);
  runs.expect_that_each_role_had_work();
}

}  // namespace
}  // namespace volccd
