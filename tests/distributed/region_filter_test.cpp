// Each test once, and by a rank that holds all elements at its features.
#include <volccd/distributed/region_filter.hpp>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/colliding_scenes.hpp>

#include "distributed/rank_numbers.hpp"
#include "support/all_tests.hpp"
#include "support/one_step.hpp"
#include "support/stages.hpp"

namespace volccd::distributed {
namespace {

MotionBox box_of(const Step& step, std::span<const Index> vertices) {
  MotionBox box;
  extend(box, step.motion, vertices, step.motion.control_points());
  return enlarged(box, step.separation);
}

MotionBox not_enlarged(const Motion& motion, std::span<const Index> vertices) {
  MotionBox box;
  extend(box, motion, vertices, motion.control_points());
  return box;
}

/// Whether the boxes are at most this far apart on each axis.
bool are_within(double distance, const MotionBox& a, const MotionBox& b) {
  return ((a.low - b.high).array() <= distance).all() && ((b.low - a.high).array() <= distance).all();
}

bool is_met(const Regions& regions, const MotionBox& box, int rank) {
  bool met = false;
  regions.meeting(box, [&](int r) { met |= r == rank; });
  return met;
}

/// The rank that keeps each test; fails if there is not exactly one.
std::vector<int> keepers(const Step& step, const Regions& regions, FeatureKind kind,
                         const std::vector<FeaturePair>& tests) {
  std::vector<int> keeper(tests.size(), -1);
  for (int r = 0; r < regions.ranks(); ++r) {
    const RegionFilter filter;
    Step of_rank = step;
    of_rank.piece.region = regions.region(r);
    TestBlock block;
    for (std::size_t begin = 0; begin < tests.size(); begin += block.size()) {
      block.gather(step, kind,
                   std::span(tests).subspan(begin).first(std::min(TestBlock::kCapacity, tests.size() - begin)));
      std::vector<std::uint8_t> keep(block.padded_size(), 1);
      test::run_stage(filter, of_rank, block, keep);
      for (std::size_t i = 0; i < block.size(); ++i) {
        if (keep[i] == 0) continue;
        EXPECT_EQ(keeper[begin + i], -1);
        keeper[begin + i] = r;
      }
    }
  }
  EXPECT_EQ(std::ranges::count(keeper, -1), 0);
  return keeper;
}

std::vector<Vec3> element_centres(const Step& step) {
  std::vector<Vec3> centres;
  for (Index o = 0; o < step.mesh().element_slots(); ++o) {
    const MotionBox box = box_of(step, step.mesh().vertices(o));
    centres.push_back(box.low / 2 + box.high / 2);
  }
  return centres;
}

/// Regions are those of the points. Returns the number of tests whose features may touch.
std::size_t check(const Step& step, FeatureKind kind, int ranks, const std::vector<Vec3>& points) {
  const Features& features = step.features();
  const Regions regions(points, std::vector<double>(points.size(), 1), ranks);
  const std::vector<FeaturePair> tests = test::all_tests(features, kind);
  const std::vector<int> keeper = keepers(step, regions, kind, tests);
  std::size_t touching = 0;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const std::array<Index, 4> v = test_vertices(features, kind, tests[i]);
    const std::size_t first = kind == FeatureKind::vf ? 1 : 2;
    if (!are_within(step.separation, not_enlarged(step.motion, std::span(v).first(first)),
                    not_enlarged(step.motion, std::span(v).subspan(first))))
      continue;
    ++touching;
    const auto [a, b] = tests[i];
    const bool vf = kind == FeatureKind::vf;
    for (const auto& elements : {vf ? features.vertex_elements(a) : features.edge_elements(a),
                                 vf ? features.triangle_elements(b) : features.edge_elements(b)})
      for (const Index o : elements) EXPECT_TRUE(is_met(regions, box_of(step, step.mesh().vertices(o)), keeper[i]));
  }
  return touching;
}

TEST(RegionFilter, EachTestIsKeptOnceByARankThatHoldsItsElements) {
  std::size_t touching = 0;
  for (const cases::Scene& scene : cases::small_scenes(5, 0.1))
    for (const double separation : {0.0, 0.3})
      for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
        for (const int ranks : test::kRankNumbers) {
          const Step step{scene.topology, scene.motion, test::kAllObjects, separation};
          touching += check(step, kind, ranks, element_centres(step));
        }
  EXPECT_GT(touching, 10000u);
}

/// Cuts have coordinates of the lattice.
TEST(RegionFilter, FeaturesOnCuts) {
  const Shape shape = block(ElementType::hexahedron, 4, 2, 2);
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, shape.positions);
  for (const double separation : {0.0, 1.0})
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      for (const int ranks : test::kRankNumbers)
        EXPECT_GT(check({topology, motion, test::kAllObjects, separation}, kind, ranks, shape.positions), 100u);
}

}  // namespace
}  // namespace volccd::distributed
