// The vector kernel for contacts at the start of a step, against the search, which decides one test at a time.
#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/narrowphase/detail/close_at_start.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

using detail::CloseAtStart;
using detail::InclusionAnswer;

/// Points in a cube, that move.
QuerySet random_queries(FeatureKind kind, int control_points, int count) {
  std::mt19937_64 random(static_cast<unsigned>(control_points));
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Vec3> points(static_cast<std::size_t>(count * control_points * 4));
  for (Vec3& p : points)
    for (double& x : p) x = number(random);
  return {kind, control_points, points};
}

/// Calls visit(block, found) for blocks of tests.
template <class Visit>
void visit_blocks(const QuerySet& set, const Step& step, std::size_t size, Visit&& visit) {
  TestBlock block;
  CloseAtStart found;
  std::array<std::uint8_t, TestBlock::kCapacity> keep;
  keep.fill(1);
  for (std::size_t begin = 0; begin < set.size(); begin += size) {
    block.gather(step, set.kind(), set.pairs().subspan(begin, std::min(size, set.size() - begin)));
    found.find(block, step.separation, keep);
    visit(block, found);
  }
}

InclusionAnswer searched(const Step& step, const TestBlock& block, std::size_t i) {
  const Inclusion::Config config;
  return detail::inclusion_search(block.kind(), detail::test_points(step.motion, block.vertices(i)),
                                  step.motion.control_points(), step.separation, config.time_tolerance,
                                  config.max_intervals, 1);
}

TEST(CloseAtStart, AreTheTestsThatTheSearchFindsAtOnce) {
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      const QuerySet set = random_queries(kind, control_points, 1001);
      const Step step = set.step(1, 0.3);
      int close = 0;
      visit_blocks(set, step, TestBlock::kCapacity, [&](const TestBlock& block, const CloseAtStart& found) {
        for (std::size_t i = 0; i < block.size(); ++i) {
          const InclusionAnswer answer = searched(step, block, i);
          ASSERT_EQ(found.contains(i), answer.outcome == InclusionAnswer::Outcome::touch && answer.at_start);
          if (!found.contains(i)) continue;
          ++close;
          const detail::ScaledClosestPoints closest = found.closest(i);
          EXPECT_EQ(closest.points.weights, answer.closest->points.weights);
          EXPECT_EQ(closest.points.separation, answer.closest->points.separation);
          EXPECT_EQ(closest.points.squared_distance, answer.closest->points.squared_distance);
          EXPECT_EQ(closest.size, answer.closest->size);
          EXPECT_EQ(closest.scale, answer.closest->scale);
        }
      });
      EXPECT_GT(close, 100);
      EXPECT_LT(close, 900);
    }
}

/// Flags and weights, test by test.
std::vector<double> answers_of(const QuerySet& set, std::size_t block_size) {
  std::vector<double> all;
  visit_blocks(set, set.step(1, 0.3), block_size, [&](const TestBlock& block, const CloseAtStart& found) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      all.push_back(found.contains(i) ? 1 : 0);
      if (!found.contains(i)) continue;
      const auto weights = found.closest(i).points.weights;
      all.insert(all.end(), weights.begin(), weights.end());
    }
  });
  return all;
}

TEST(CloseAtStart, AnswersDependNeitherOnTheBlockNorOnTheInstructionSet) {
  const cases::InstructionSets sets;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      const QuerySet set = random_queries(kind, control_points, 333);
      const std::vector<double> best = answers_of(set, TestBlock::kCapacity);
      EXPECT_EQ(answers_of(set, 1), best);
      sets.with_each([&](const char* name) { EXPECT_EQ(answers_of(set, TestBlock::kCapacity), best) << name; });
    }
}

/// Tests that are not to be kept are not reported, also where others of their group are examined.
TEST(CloseAtStart, LeavesOutTestsThatAreSettled) {
  const QuerySet set = random_queries(FeatureKind::ee, 2, 8);
  const Step step = set.step(1, 9);
  TestBlock block;
  block.gather(step, set.kind(), set.pairs());
  std::array<std::uint8_t, TestBlock::kCapacity> keep = {};
  CloseAtStart found;
  found.find(block, step.separation, keep);
  for (std::size_t i = 0; i < block.size(); ++i) EXPECT_FALSE(found.contains(i));
  keep[5] = 1;
  found.find(block, step.separation, keep);
  EXPECT_TRUE(found.contains(5));
}

/// Below the range of ordinary sizes, and where vertices coincide, the search decides.
TEST(CloseAtStart, LeavesTestsOutOfRangeToTheSearch) {
  const std::array<Vec3, 8> one = {Vec3(0, 0, 1), Vec3(-1, -1, 0), Vec3(2, 0, 0), Vec3(0, 2, 0),
                                   Vec3(0, 0, 1), Vec3(-1, -1, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)};
  const auto found = [&](double scale, const Vec3& apex) {
    Query query = one;
    query[0] = query[4] = apex;
    for (Vec3& p : query) p *= scale;
    const QuerySet set(FeatureKind::vf, std::vector<Query>{query});
    bool close = false;
    visit_blocks(set, set.step(1, 2 * scale), 1,
                 [&](const TestBlock&, const CloseAtStart& tests) { close = tests.contains(0); });
    return close;
  };
  EXPECT_TRUE(found(1, one[0]));
  EXPECT_TRUE(found(0x1p-90, one[0]));
  EXPECT_FALSE(found(0x1p-110, one[0]));
  EXPECT_FALSE(found(0x1p110, one[0]));
  EXPECT_FALSE(found(1, one[2]));
}

}  // namespace
}  // namespace volccd::test
