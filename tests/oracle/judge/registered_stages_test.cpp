// All stages of the library keep their promises: check_stage() with each combination of the choices among their
// options, on each instruction set. Stages that are registered later are checked without a change here.
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/oracle/judge/stage_check.hpp>

#include "support/all_stages.hpp"
#include "support/allocations.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

std::vector<std::string> choices_of(const OptionInfo& option) {
  std::vector<std::string> choices;
  std::istringstream text(option.allowed);
  for (std::string choice; std::getline(text, choice, '|');) choices.push_back(choice);
  return choices;
}

/// All combinations of the choices, the defaults first. Numbers keep their defaults.
std::vector<OptionValues> variants(const std::vector<OptionInfo>& options) {
  std::vector<OptionValues> all(1);
  for (const OptionInfo& option : options) {
    const std::vector<std::string> choices = choices_of(option);
    if (choices.size() < 2) continue;
    const std::size_t before = all.size();
    for (const std::string& choice : choices)
      for (std::size_t i = 0; i < before && choice != option.default_value; ++i) {
        all.push_back(all[i]);
        all.back()[option.name] = choice;
      }
  }
  return all;
}

std::string text_of(const StageReport& report, const OptionValues& options) {
  std::string text = report.stage;
  for (const auto& [name, value] : options) text += " " + name + "=" + value;
  for (const PromiseReport& one : report.promises)
    if (!one.kept())
      text += "\n" + one.promise + ": " + std::to_string(one.broken) + " of " + std::to_string(one.checked) + ", " +
              one.example;
  return text;
}

template <class Kind>
std::vector<std::string> names() {
  std::vector<std::string> all;
  const Registry registry = test::all_stages();
  for (const auto& descriptor : registry.stages<Kind>()) all.push_back(descriptor.name);
  return all;
}

/// A suite for each role, so that each can be selected by its name.
template <class Kind>
class StagePromises : public testing::TestWithParam<std::string> {
 protected:
  /// Checks all variants. `all_trials`: their sum, but at least `min_each` for each.
  void check(int all_trials, int min_each, bool pipelines, std::uint64_t first_seed = 1) {
    const Registry registry = test::all_stages();
    const std::vector<OptionValues> all = variants(registry.stage<Kind>(GetParam()).options);
    StageCheckConfig config;
    config.seed = first_seed;
    config.trials = test::trials(std::max(all_trials / static_cast<int>(all.size()), min_each));
    config.pipelines = pipelines;
    config.allocation_count = test::allocation_count;
    for (const OptionValues& options : all) {
      config.options = options;
      const StageReport report = check_stage(registry, GetParam(), config);
      EXPECT_TRUE(report.kept()) << text_of(report, options);
      EXPECT_GE(report.promises.size(), 2u);
      for (const PromiseReport& one : report.promises) EXPECT_GT(one.checked, 0u) << one.promise;
      config.seed += static_cast<std::uint64_t>(config.trials);
      config.pipelines = false;
    }
  }
};

template <class Kind>
auto all_of() {
  return testing::ValuesIn(names<Kind>());
}
std::string stage_of(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

using BroadPhasePromises = StagePromises<BroadPhase>;
using ElementCullingPromises = StagePromises<ElementCulling>;
using AssignmentPromises = StagePromises<Assignment>;
using OrphanSourcePromises = StagePromises<OrphanSource>;
using FloodPromises = StagePromises<Flood>;
using FeatureFilterPromises = StagePromises<FeatureFilter>;
using NarrowPhasePromises = StagePromises<NarrowPhase>;

TEST_P(BroadPhasePromises, AreKept) { check(2000, 300, true); }
TEST_P(ElementCullingPromises, AreKept) { check(4000, 300, true); }
TEST_P(AssignmentPromises, AreKept) { check(300, 300, true); }
TEST_P(OrphanSourcePromises, AreKept) { check(600, 300, true); }
TEST_P(FloodPromises, AreKept) { check(300, 300, true); }
TEST_P(FeatureFilterPromises, AreKept) { check(4000, 400, true); }
TEST_P(NarrowPhasePromises, AreKept) { check(300, 50, true); }

class LongBroadPhasePromises : public BroadPhasePromises {};
class LongElementCullingPromises : public ElementCullingPromises {};
class LongFeatureFilterPromises : public FeatureFilterPromises {};
class LongNarrowPhasePromises : public NarrowPhasePromises {};

TEST_P(LongBroadPhasePromises, AreKept) { check(10'000, 300, false, 10'000'000); }
TEST_P(LongElementCullingPromises, AreKept) { check(10'000, 300, false, 10'000'000); }
TEST_P(LongFeatureFilterPromises, AreKept) { check(10'000, 400, false, 10'000'000); }
/// Fewer trials, because exact arithmetic judges every test.
TEST_P(LongNarrowPhasePromises, AreKept) { check(500, 50, false, 10'000'000); }

INSTANTIATE_TEST_SUITE_P(All, BroadPhasePromises, all_of<BroadPhase>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, ElementCullingPromises, all_of<ElementCulling>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, AssignmentPromises, all_of<Assignment>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, OrphanSourcePromises, all_of<OrphanSource>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, FloodPromises, all_of<Flood>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, FeatureFilterPromises, all_of<FeatureFilter>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, NarrowPhasePromises, all_of<NarrowPhase>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, LongBroadPhasePromises, all_of<BroadPhase>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, LongElementCullingPromises, all_of<ElementCulling>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, LongFeatureFilterPromises, all_of<FeatureFilter>(), stage_of);
INSTANTIATE_TEST_SUITE_P(All, LongNarrowPhasePromises, all_of<NarrowPhase>(), stage_of);

}  // namespace
}  // namespace volccd
