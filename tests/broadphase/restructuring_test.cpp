// A tree that is kept from step to step stays nearly as good as a new one: parts that a motion mixes up are rebuilt.
#include <numeric>

#include <volccd/peers/peers.hpp>

#include "broadphase/scenes.hpp"
#include "support/allocations.hpp"

namespace volccd::test {
namespace {

/// Blocks that have gone a part of the way to random positions.
std::vector<Vec3> scattered(const Shape& shape, std::size_t vertices_a_block, double part) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(0, 12);
  std::vector<Vec3> positions = shape.positions;
  for (std::size_t first = 0; first < positions.size(); first += vertices_a_block) {
    const Vec3 by(place(random), place(random), place(random));
    for (std::size_t v = first; v < first + vertices_a_block; ++v) positions[v] += part * by;
  }
  return positions;
}

std::uint64_t tests_of_query(const KdopBvh& phase, const Step& step, StageState& state, Executor& executor) {
  const std::uint64_t before = KdopBvh::counters(state).node_tests;
  query(phase, step, state, PairRange::nonadjacent, executor);
  return KdopBvh::counters(state).node_tests - before;
}

/// Number of node tests of the last step of a long motion, and of a tree that is built for this step.
struct Cost {
  double kept, fresh;
  std::uint64_t builds, restructured;
};

Cost long_motion(KdopBvh::Restructure restructure, Scene& scene, const std::vector<std::vector<Vec3>>& frames) {
  KdopBvh::Config config;
  config.restructure = restructure;
  const KdopBvh phase(config);
  const auto state = phase.make_state(), fresh = phase.make_state();
  SerialExecutor executor;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    scene.motion = Motion::linear(frames[i], frames[i + 1]);
    phase.prepare(scene.step(), *state, executor);
  }
  phase.prepare(scene.step(), *fresh, executor);
  EXPECT_EQ(query(phase, scene.step(), *state, PairRange::every, executor),
            query(phase, scene.step(), *fresh, PairRange::every, executor));
  const KdopBvh::Counters& counters = KdopBvh::counters(*state);
  return {static_cast<double>(tests_of_query(phase, scene.step(), *state, executor)),
          static_cast<double>(tests_of_query(phase, scene.step(), *fresh, executor)), counters.builds,
          counters.restructured_elements};
}

TEST(Restructuring, KeepsTheCostOfMixedUpElementsNearThatOfABuild) {
  // A sheet of single elements with independent motions, so that every tree degrades.
  Shape shape;
  const Shape one = block(ElementType::hexahedron, 1, 1, 1);
  for (int i = 0; i < 4000; ++i) {
    Shape cell = one;
    shape.append(cell.translate({1.2 * (i % 16), 1.2 * (i / 16 % 16), 1.2 * (i / 256)}), 0);
  }
  std::vector<std::vector<Vec3>> frames;
  for (int f = 0; f <= 30; ++f) frames.push_back(scattered(shape, 8, f / 30.0));
  Scene scene = make_scene("cloud", shape, shape.positions);
  const Cost refit = long_motion(KdopBvh::Restructure::none, scene, frames);
  const Cost kept = long_motion(KdopBvh::Restructure::subtrees, scene, frames);
  EXPECT_GT(refit.kept, 2 * refit.fresh) << "the motion does not degrade a tree: the test shows nothing";
  EXPECT_LT(kept.kept, 1.5 * kept.fresh);
  EXPECT_GT(kept.restructured, 0u);
}

TEST(Restructuring, OnlyThePartThatDegraded) {
  // Two clouds; only the smaller one is permuted.
  Shape shape;
  const Shape one = block(ElementType::hexahedron, 1, 1, 1);
  for (int i = 0; i < 4500; ++i) {
    Shape cell = one;
    const double x = i < 4000 ? 0 : 100;
    shape.append(cell.translate({x + 1.2 * (i % 10), 1.2 * (i / 10 % 10), 1.2 * (i % 4000 / 100)}), 0);
  }
  const std::vector<Vec3> mixed = scattered(shape, 8, 1);
  std::vector<std::vector<Vec3>> frames(21, shape.positions);
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (std::size_t v = 4000 * 8; v < shape.positions.size(); ++v)
      frames[f][v] += static_cast<double>(f) / 20 * (mixed[v] - shape.positions[v]);
  Scene scene = make_scene("two clouds", shape, shape.positions);
  const Cost kept = long_motion(KdopBvh::Restructure::subtrees, scene, frames);
  EXPECT_LT(kept.kept, 1.5 * kept.fresh);
  EXPECT_EQ(kept.builds, 1u);
  EXPECT_GT(kept.restructured, 0u);
  EXPECT_LT(kept.restructured, 20 * 600u) << "the large cloud was rebuilt though it rests";
}

TEST(Restructuring, NothingWhereTheMotionDoesNotDegrade) {
  const Shape shape = block(ElementType::tetrahedron, 10, 10, 10);
  std::vector<std::vector<Vec3>> frames;
  for (int f = 0; f < 30; ++f) frames.push_back(scaled(shape.positions, std::pow(1.2, f)));
  Scene scene = make_scene("growing", shape, shape.positions);
  const Cost kept = long_motion(KdopBvh::Restructure::subtrees, scene, frames);
  EXPECT_EQ(kept.builds, 1u);
  EXPECT_EQ(kept.restructured, 0u);
}

TEST(Restructuring, FastAndSlowStepsByTurnsDoNotRebuildTheTreeAgainAndAgain) {
  const Shape shape = block(ElementType::tetrahedron, 10, 10, 10);
  std::vector<std::vector<Vec3>> frames{shape.positions};
  for (int f = 0; f < 40; ++f) {
    frames.push_back(frames.back());
    for (Vec3& p : frames.back()) p += f / 2 % 2 == 0 ? Vec3(5, 3, 1) : Vec3(0.01, 0, 0);
  }
  Scene scene = make_scene("stop and go", shape, shape.positions);
  const Cost kept = long_motion(KdopBvh::Restructure::subtrees, scene, frames);
  EXPECT_LE(kept.restructured, 3 * shape.elements.size());
}

TEST(Restructuring, TwistedBlock) {
  const Shape shape = block(ElementType::tetrahedron, 8, 8, 24);
  std::vector<std::vector<Vec3>> frames;
  for (int f = 0; f <= 36; ++f) {
    frames.push_back(shape.positions);
    for (Vec3& p : frames.back()) {
      const double angle = f / 36.0 * 2 * M_PI * p[2] / 24, x = p[0] - 4, y = p[1] - 4;
      p = Vec3(std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y, p[2]);
    }
  }
  Scene scene = make_scene("twist", shape, shape.positions);
  const Cost kept = long_motion(KdopBvh::Restructure::subtrees, scene, frames);
  EXPECT_LT(kept.kept, 1.3 * kept.fresh);
}

}  // namespace
}  // namespace volccd::test
