// Requirements for every broad phase, on all scenes: compared with an oracle in exact arithmetic, and with each other.
#include <hwy/targets.h>

#include <volccd/peers/peers.hpp>

#include "broadphase/scenes.hpp"

namespace volccd::test {
namespace {

class KdopPhases : public ::testing::TestWithParam<int> {};

TEST_P(KdopPhases, EmitExactOverlapsAndNothingClearlyApart) {
  const int k = GetParam();
  const auto tree = make(describe_kdop_bvh(), {{"k", std::to_string(k)}});
  const auto hash = make(describe_spatial_hash(), {{"k", std::to_string(k)}});
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const Step step = scene.step();
    const KdopOracle oracle(step, k);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
      const Pairs pairs = run_fresh(*tree, step, range);
      expect_sound(pairs, oracle, step, range);
      EXPECT_EQ(pairs, run_fresh(*hash, step, range)) << "hash and tree differ";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllK, KdopPhases, ::testing::Values(6, 14, 16, 18, 24, 26));

TEST(KdopBvhTest, LeafSizeDoesNotMatter) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
      const Pairs expected =
          run_fresh(*make(describe_kdop_bvh(), {{"adjacent_pairs", "vertices"}}), scene.step(), range);
      for (int leaf_size : {1, 2, 3, 4, 5, 7, 8})
        EXPECT_EQ(expected, run_fresh(*make(describe_kdop_bvh(), {{"leaf_size", std::to_string(leaf_size)}}),
                                      scene.step(), range))
            << leaf_size;
    }
  }
}

TEST(SpatialHashTest, CellSizeDoesNotMatter) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const Pairs expected = run_fresh(*make(describe_kdop_bvh()), scene.step());
    for (const char* cell : {"0.05", "0.3", "2.5", "100"})
      EXPECT_EQ(expected, run_fresh(*make(describe_spatial_hash(), {{"cell_size", cell}}), scene.step())) << cell;
  }
}

TEST(BruteForceTest, BoxesAreExact) {
  const auto boxes = make(describe_brute_force());
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    const Step step = scene.step();
    const KdopOracle oracle(step, 6);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
      const Pairs pairs = run_fresh(*boxes, step, range);
      expect_sound(pairs, oracle, step, range, scene.separation > 0 ? 1e-14 : 0, scene.separation > 0 ? 1e-320 : 0);
    }
  }
}

TEST(BruteForceTest, WithoutBoundsEveryPair) {
  const auto every = make(describe_brute_force(), {{"bounds", "none"}});
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every})
      EXPECT_EQ(run_fresh(*every, scene.step(), range), all_pairs(scene.step(), range));
  }
}

TEST(BroadPhases, QuadraticMotionEnclosesItsControlPoints) {
  const Shape shape = mixed_block(2, 2);
  Scene scene = make_scene("quadratic", shape, shape.positions);
  scene.motion =
      Motion::quadratic(shape.positions, jittered(shape.positions, 1.5, 1), jittered(shape.positions, 0.2, 2));
  const Step step = scene.step();
  const KdopOracle dops(step, 16), boxes(step, 6);
  expect_sound(run_fresh(*make(describe_kdop_bvh()), step), dops, step, PairRange::every);
  expect_sound(run_fresh(*make(describe_spatial_hash()), step), dops, step, PairRange::every);
  expect_sound(run_fresh(*make(describe_brute_force()), step), boxes, step, PairRange::every, 0, 0);
}

std::vector<std::unique_ptr<BroadPhase>> all_phases() {
  std::vector<std::unique_ptr<BroadPhase>> phases;
  phases.push_back(make(describe_kdop_bvh()));
  phases.push_back(make(describe_kdop_bvh(), {{"k", "6"}, {"leaf_size", "8"}}));
  phases.push_back(make(describe_spatial_hash()));
  phases.push_back(make(describe_brute_force()));
  phases.push_back(make(describe_brute_force(), {{"bounds", "none"}}));
  for (const auto& peer : describe_peers()) phases.push_back(make(peer));
  return phases;
}

TEST(BroadPhases, WorkersDoNotMatter) {
  Shape shape = permuted(block(ElementType::tetrahedron, 9, 8, 7), 1);
  shape.append(with_outliers(), 1);
  Scene scene = make_scene("block", shape, jittered(shape.positions, 0.3, 1));
  for (const auto& phase : all_phases()) {
    const Pairs expected = run_fresh(*phase, scene.step(), PairRange::nonadjacent);
    EXPECT_GT(expected.size(), 10000u);
    const auto state = phase->make_state();
    for (unsigned workers : {4u, 1u, 3u, 2u}) {
      const auto executor = make_thread_executor(workers);
      EXPECT_EQ(run(*phase, scene.step(), *state, PairRange::nonadjacent, *executor), expected) << workers;
    }
  }
}

/// A face of each tetrahedron, where faces count as adjacent if their tetrahedra are.
TEST(BroadPhases, AdjacencyMayBeThatOfOtherElements) {
  const Shape shape = permuted(block(ElementType::tetrahedron, 5, 4, 3), 1);
  const Topology tetrahedra(shape.mesh());
  const Mesh& mesh = tetrahedra.mesh();
  Mesh faces;
  faces.add_vertices(mesh.vertex_ids());
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    const std::span<const Index> vertices = mesh.vertices(o);
    faces.add_element({.type = ElementType::triangle, .vertices = {vertices.begin(), vertices.begin() + 3}, .id = o});
  }
  Scene scene;
  scene.topology = std::make_unique<Topology>(std::move(faces));
  scene.motion = Motion::linear(shape.positions, jittered(shape.positions, 0.5, 1));
  Step step = scene.step();
  auto phases = all_phases();
  phases.push_back(make(describe_kdop_bvh(), {{"adjacent_pairs", "vertices"}}));
  phases.push_back(make(describe_kdop_bvh(), {{"restructure", "always"}}));
  for (const auto& phase : phases) {
    step.adjacency_table = nullptr;
    Pairs expected = run_fresh(*phase, step, PairRange::nonadjacent);
    const std::size_t removed =
        std::erase_if(expected, [&](ElementPair pair) { return tetrahedra.adjacency().adjacent(pair.a, pair.b); });
    EXPECT_GT(removed, 100u);
    EXPECT_GT(expected.size(), 100u);
    step.adjacency_table = &tetrahedra.adjacency();
    EXPECT_EQ(run_fresh(*phase, step, PairRange::nonadjacent), expected);
  }
}

TEST(BroadPhases, InstructionSetsDoNotMatter) {
  const std::vector<Scene> all = scenes();
  const auto phases = all_phases();
  std::vector<Pairs> expected;
  for (const Scene& scene : all)
    for (const auto& phase : phases) expected.push_back(run_fresh(*phase, scene.step(), PairRange::nonadjacent));
  const auto supported = hwy::SupportedTargets();
  // All instruction sets, from the widest downwards, and at the end without any.
  for (auto targets = supported; targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().DeInit();
    std::size_t next = 0;
    for (const Scene& scene : all)
      for (const auto& phase : phases) {
        EXPECT_EQ(run_fresh(*phase, scene.step(), PairRange::nonadjacent), expected[next++]) << scene.name << targets;
      }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(BroadPhases, FiltersDropWhatTheyMayAndNothingElse) {
  // Object 1 shares vertices with object 0 along a face; objects 2 and 3 share none.
  Shape shape = block(ElementType::hexahedron, 6, 2, 2);
  for (std::size_t i = 0; i < shape.elements.size(); ++i) shape.elements[i].object = i % 6 < 3 ? 0 : 1;
  Shape other = block(ElementType::tetrahedron, 3, 2, 2);
  shape.append(other.translate({2.4, 0.7, 0.9}), 2).append(other.translate({0.5, 0.1, 0.2}), 3);
  std::vector<ObjectFilter> filters(7);
  filters[1] = ObjectFilter(PairScope::inter);
  filters[2] = ObjectFilter(PairScope::intra);
  filters[3].exclude(0, 1);
  filters[4].exclude(2, 3), filters[4].exclude(0, 0), filters[4].exclude(1, 1), filters[4].exclude(3, 3);
  filters[5] = ObjectFilter(PairScope::inter), filters[5].exclude(2, 3);
  Scene scene = make_scene("filters", shape, jittered(shape.positions, 0.3, 1));
  ASSERT_TRUE(scene.topology->objects_share_vertices());
  for (const auto& phase : all_phases()) {
    const auto state = phase->make_state();
    SerialExecutor executor;
    for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
      scene.filter = {};
      const Pairs unfiltered = run(*phase, scene.step(), *state, range, executor);
      for (const ObjectFilter& filter : filters) {
        scene.filter = filter;
        Pairs expected;
        for (const ElementPair& pair : unfiltered)
          if (!filter.drops(*scene.topology, pair)) expected.push_back(pair);
        EXPECT_EQ(run(*phase, scene.step(), *state, range, executor), expected);
      }
    }
  }
}

TEST(BroadPhases, ManyObjects) {
  Shape shape;
  for (int i = 0; i < 1100; ++i) {
    Shape one = block(ElementType::tetrahedron, 1, 1, 1);
    one.elements.resize(2);
    shape.append(one.translate({0.3 * (i % 37), 0.4 * (i / 37), 0}), i * 3 - 500);
  }
  Scene scene = make_scene("many", shape, shape.positions);
  for (ObjectFilter filter : {ObjectFilter(PairScope::inter), ObjectFilter(PairScope::intra)}) {
    filter.exclude(-500, -497);
    scene.filter = filter;
    const Pairs expected = run_fresh(*make(describe_kdop_bvh()), scene.step());
    EXPECT_GT(expected.size(), 1000u);
    for (const ElementPair& pair : expected) ASSERT_FALSE(filter.drops(*scene.topology, pair));
    EXPECT_EQ(expected, run_fresh(*make(describe_spatial_hash()), scene.step()));
    scene.filter = {};
    std::size_t wanted = 0;
    for (const ElementPair& pair : run_fresh(*make(describe_kdop_bvh()), scene.step()))
      wanted += !filter.drops(*scene.topology, pair);
    EXPECT_EQ(expected.size(), wanted);
  }
}

TEST(BroadPhases, EmptyAndSingleElementMeshes) {
  Shape none;
  none.positions.assign(3, Vec3::Zero());
  Shape one = block(ElementType::hexahedron, 1, 1, 1);
  for (const auto& phase : all_phases()) {
    EXPECT_TRUE(run_fresh(*phase, make_scene("none", none, none.positions).step()).empty());
    const Scene scene = make_scene("one", one, one.positions);
    EXPECT_EQ(run_fresh(*phase, scene.step()), (Pairs{{0, 0}}));
    EXPECT_TRUE(run_fresh(*phase, scene.step(), PairRange::nonadjacent).empty());
  }
}

TEST(BroadPhases, DescribeTheirOptionsAndRefuseOthers) {
  for (const auto& descriptor : {describe_kdop_bvh(), describe_spatial_hash(), describe_brute_force()}) {
    EXPECT_EQ(descriptor.guarantee, Guarantee::conservative);
    OptionValues defaults;
    for (const OptionInfo& info : descriptor.options) defaults[info.name] = info.default_value;
    EXPECT_NO_THROW(descriptor.make(defaults));
    EXPECT_THROW(descriptor.make({{"colour", "red"}}), ConfigError);
  }
  EXPECT_THROW(make(describe_kdop_bvh(), {{"k", "15"}}), ConfigError);
  EXPECT_THROW(make(describe_kdop_bvh(), {{"leaf_size", "9"}}), ConfigError);
  EXPECT_THROW(make(describe_spatial_hash(), {{"cell_size", "0"}}), ConfigError);
  KdopBvh::Config config;
  config.k = 8;
  EXPECT_THROW(KdopBvh{config}, ConfigError);
  config.k = 16, config.leaf_size = 0;
  EXPECT_THROW(KdopBvh{config}, ConfigError);
  SpatialHash::Config cells;
  cells.cell_size = std::nan("");
  EXPECT_THROW(SpatialHash{cells}, ConfigError);
}

}  // namespace
}  // namespace volccd::test
