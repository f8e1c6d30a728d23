// The generators of difficult tests have the properties that they state.
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/oracle/cases/test_scene.hpp>
#include <volccd/pipelines/registry.hpp>

#include "support/stages.hpp"

namespace volccd::cases {
namespace {

std::vector<Attack> all_attacks() {
  std::vector<Attack> all(touching_attacks().begin(), touching_attacks().end());
  all.insert(all.end(), separation_attacks().begin(), separation_attacks().end());
  return all;
}
TEST(AttackCases, AreFiniteAndManyTouch) {
  for (const Attack& attack : all_attacks()) {
    int known = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
      Choices choices(seed);
      const Case c = attack_test(choices, attack);
      bool finite = std::isfinite(c.separation);
      for (const auto& set : c.sets)
        for (const Curve& p : set)
          for (const Vec3& x : p) finite = finite && x.allFinite();
      ASSERT_TRUE(finite) << attack.name << " " << seed;
      known += c.touch >= 0;
    }
    // the time is rounded, and not known exactly
    const std::set<std::string> nearly = {"NearMiss", "FarOff", "NearlyAtTheSeparation"};
    EXPECT_TRUE(known > 100 || nearly.count(attack.name)) << attack.name << " " << known;
  }
}

TEST(NearDegenerate, TouchesAsItSays) {
  for (std::uint64_t seed = 1'000'000; seed < 1'003'000; ++seed) {
    Choices choices(seed);
    const Case c = near_degenerate_test(choices);
    if (c.touch < 0) continue;
    const ExactAnswer answer = exact_first_touch(Coordinates(c).motion());
    ASSERT_TRUE(answer.touches && answer.toi <= c.touch) << seed << to_text(c);
  }
  for (std::uint64_t seed = 2'000'000; seed < 2'003'000; ++seed) {
    Choices choices(seed);
    const Case c = near_degenerate_test(choices, Separation::some);
    if (c.touch < 0) continue;
    ASSERT_LE(compare_distance(Coordinates(c).motion(), c.touch, c.separation), 0) << seed << to_text(c);
    const ExactAnswer answer = exact_first_touch(Coordinates(c).motion(), 1, c.separation);
    ASSERT_TRUE(answer.touches && answer.toi <= c.touch) << seed << to_text(c);
  }
}

TEST(NearDegenerate, HasEveryCase) {
  double at_start = 0, crossing = 0, grazing = 0, coplanar = 0, degenerate = 0, apart = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    Choices choices(seed);
    const ExactAnswer answer = exact_first_touch(Coordinates(near_degenerate_test(choices)).motion());
    at_start += answer.reason == TouchCase::at_start;
    crossing += answer.reason == TouchCase::crossing;
    grazing += answer.reason == TouchCase::grazing;
    coplanar += answer.reason == TouchCase::coplanar;
    apart += answer.reason == TouchCase::apart;
    degenerate += answer.degenerate;
  }
  for (const double cases : {at_start, crossing, grazing, coplanar, apart, degenerate}) EXPECT_GT(cases, 60);
}

bool apart_along_an_axis(const Case& c) {
  for (int axis = 0; axis < 3; ++axis) {
    bool ahead = true, behind = true;
    for (const Curve& p : c.sets[0])
      for (const Curve& q : c.sets[1])
        for (std::size_t k = 0; k < static_cast<std::size_t>(c.control_points); ++k) {
          ahead = ahead && p[k][axis] < q[k][axis];
          behind = behind && p[k][axis] > q[k][axis];
        }
    if (ahead || behind) return true;
  }
  return false;
}

/// Fractions of the generated tests that some filter drops, and of those among them that no coordinate axis separates.
TEST(LongNearDegenerate, FiltersDropManyThatAreNear) {
  const Registry registry = Registry::standard();
  std::vector<std::unique_ptr<FeatureFilter>> filters;
  for (const auto& descriptor : registry.stages<FeatureFilter>()) filters.push_back(descriptor.make({}));
  const auto is_dropped = [&](const Case& c) {
    TestScene scene;
    scene.set(0, c);
    const Step step = scene.step(c.control_points, c.separation, 1);
    const FeaturePair pair = scene.pair(c.kind, 0);
    TestBlock block;
    block.gather(step, c.kind, {&pair, 1});
    for (const auto& filter : filters) {
      std::uint8_t keep[8] = {1, 1, 1, 1, 1, 1, 1, 1};
      test::run_stage(*filter, step, block, keep);
      if (!keep[0]) return true;
    }
    return false;
  };
  constexpr int kTests = 30'000;
  for (const Separation separation : {Separation::none, Separation::some}) {
    int dropped = 0, judged = 0;
    for (std::uint64_t seed = 1; seed <= kTests; ++seed) {
      Choices choices(seed);
      const Case c = near_degenerate_test(choices, separation);
      if (!is_dropped(c)) continue;
      ++dropped;
      judged += !apart_along_an_axis(c);
    }
    EXPECT_GT(dropped, (separation == Separation::none ? 0.02 : 0.005) * kTests);
    if (separation == Separation::none) {
      EXPECT_GT(judged, 0.01 * kTests) << "nearly touching tests are missing";
    }
  }
}

}  // namespace
}  // namespace volccd::cases
