// `VolCCD+` loses no contact on meshes that are made to break floods and vertex stars. VOLCCD_HOSTILE_SEED sets the
// first seed of the long test, VOLCCD_HOSTILE_REPORTED how many failures it reports.
#include <gtest/gtest.h>

#include <volccd/oracle/judge/hostile_judge.hpp>

#include "pipelines/scenes.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

using test::from_environment;
using test::registry;
using test::trials;

HostileJudge all_pipelines() {
  return {registry(), {forced_flood(registry()), default_flood(registry()), forced_star_orphans(registry())}};
}

class HostileMember : public testing::TestWithParam<cases::HostileMember> {};

TEST_P(HostileMember, LosesNoContact) {
  HostileJudge judge = all_pipelines();
  EXPECT_EQ(judge.judge(GetParam().make()), "");
  EXPECT_GT(judge.counters().contacts, 0u);
}
INSTANTIATE_TEST_SUITE_P(All, HostileMember, testing::ValuesIn(cases::hostile_members()),
                         [](const auto& of) { return of.param.name; });

class HostileMeshFamily : public testing::TestWithParam<cases::HostileFamily> {};

TEST_P(HostileMeshFamily, LosesNoContact) {
  HostileJudge judge = all_pipelines();
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(trials(30)) && !HasFailure(); ++seed) {
    cases::Choices choices(seed);
    EXPECT_EQ(judge.judge(make_hostile(choices, GetParam())), "") << "seed " << seed;
  }
  EXPECT_GT(judge.counters().contacts, static_cast<std::uint64_t>(trials(100)));
}
INSTANTIATE_TEST_SUITE_P(All, HostileMeshFamily, testing::ValuesIn(cases::hostile_families()),
                         [](const auto& of) { return of.param.name; });

TEST(HostileMeshes, TheSameSeedGivesTheSameCase) {
  cases::Choices first(7), second(7);
  EXPECT_EQ(to_text(cases::make_hostile(first)), to_text(cases::make_hostile(second)));
}

/// Continues after a failure, and reports the first ones.
TEST(LongHostileMeshes, LoseNoContact) {
  const std::uint64_t first = from_environment("VOLCCD_HOSTILE_SEED", 1);
  const std::uint64_t count = static_cast<std::uint64_t>(trials(3000));
  const std::uint64_t max_reported = from_environment("VOLCCD_HOSTILE_REPORTED", 5);
  HostileJudge judge = all_pipelines();
  std::uint64_t failures = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const std::string problem = judge.judge_seed(seed);
    if (problem.empty() || ++failures > max_reported) continue;
    cases::Choices choices(seed);
    ADD_FAILURE() << problem << "\nReduced: " << judge.reduced_text(cases::make_hostile(choices));
  }
  EXPECT_EQ(failures, 0u) << "of " << count << " meshes";
  EXPECT_GT(judge.counters().contacts, count);
  EXPECT_GE(judge.counters().initial_overlaps, count > 100 ? 1u : 0u);
}

}  // namespace
}  // namespace volccd
