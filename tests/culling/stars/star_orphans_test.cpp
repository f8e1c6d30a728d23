// Where star orphans are used in place of the O-Set, and after edits.
#include <volccd/culling/stars/star_orphans.hpp>

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/stars/jittered_block.hpp"
#include "culling/stars/some_elements.hpp"

namespace volccd::detail {
namespace {

/// The O-Set provides the orphans where stars decide nothing.
TEST(StarOrphans, LeavesSomeStepsToTheOSet) {
  SerialExecutor serial;
  const StarOrphans source({});
  const auto by_stars = [&](const Shape& shape, double amount, double separation) {
    const JitteredBlock block(shape, amount, 3);
    const auto state = source.make_state();
    source.prepare(block.step(separation), *state, serial);
    return StarOrphans::counters(*state).by_stars;
  };
  const Shape solid = block(ElementType::hexahedron, 3, 3, 3), sheet = block(ElementType::triangle, 3, 3, 1);
  EXPECT_TRUE(by_stars(solid, 0.05, 0));
  EXPECT_TRUE(by_stars(solid, 0.05, 0.01)) << "separation";
  EXPECT_FALSE(by_stars(solid, 0.05, 0.9)) << "separation";
  EXPECT_FALSE(by_stars(solid, 3, 0)) << "most stars fold";
  EXPECT_FALSE(by_stars(sheet, 0, 0)) << "no volumes";
}

/// Of thickened shells without their neighbours few orphans are left, and of a volume beside them many. A state follows
/// steps that ask for other contacts.
TEST(StarOrphans, LeavesThickenedShellsToTheOSet) {
  SerialExecutor serial;
  const StarOrphans source({});
  const Shape sheet = block(ElementType::quad, 3, 3, 1);
  const ObjectFilter filter;
  Shape both = sheet;
  both.append(block(ElementType::hexahedron, 1, 1, 1).translate(Vec3(0, 0, 5)), 1);
  for (const auto& [shape, volumes] : {std::pair{sheet, false}, {both, true}}) {
    const Mesh shells = shape.mesh();
    const ShellThickener thickener(shells);
    const Topology topology(thickener.solid_mesh(shells));
    std::vector<Vec3> x;
    thickener.positions(shape.positions, std::vector<double>(shells.element_slots(), 0.1), x);
    const Motion motion = Motion::linear(x, x);
    const auto state = source.make_state();
    Step step{topology, motion, filter};
    for (const bool leave_out : {false, true, false}) {
      step.leave_out_shell_neighbours = leave_out;
      source.prepare(step, *state, serial);
      EXPECT_EQ(StarOrphans::counters(*state).by_stars, volumes || !leave_out) << leave_out;
    }
  }
}

/// While a block falls to pieces, a state that is kept lists the same orphans as a new one.
TEST(StarOrphans, FollowEdits) {
  SerialExecutor serial;
  const StarOrphans source({.max_suspect_fraction = 1});
  const Shape shape = block(ElementType::hexahedron, 4, 4, 4);
  Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, jittered(shape.positions, 0.3, 5));
  const ObjectFilter filter;
  const Step step{topology, motion, filter};
  const auto orphans = [&](StageState& state) {
    Work work;
    TestBatch& all = work.tests;
    source.prepare(step, state, serial);
    for (std::size_t block = 0; block < source.blocks(state); ++block) source.run(step, state, 0, block, work);
    std::sort(all.vf.begin(), all.vf.end());
    std::sort(all.ee.begin(), all.ee.end());
    return all;
  };
  const auto kept = source.make_state();
  Random random(3);
  for (int edit = 0; edit < 8; ++edit) {
    if (edit > 0) topology.apply({some_elements(topology.mesh(), random, 0.15), {}, {}});
    const auto fresh = source.make_state();
    const TestBatch expected = orphans(*fresh), found = orphans(*kept);
    EXPECT_GT(expected.ee.size(), 20u) << edit;
    EXPECT_EQ(found.vf, expected.vf) << edit;
    EXPECT_EQ(found.ee, expected.ee) << edit;
  }
}

}  // namespace
}  // namespace volccd::detail
