// Coordinates beyond the range of floats, among others: bounds remain finite, so that the keys by which a tree is
// divided may overflow to an infinite value but are never NaN, which would have no place in an order.
#include <volccd/broadphase/bvh/detail/tree_builder.hpp>

#include <array>
#include <numeric>

#include "broadphase/scenes.hpp"

namespace volccd::test {
namespace {

/// Tetrahedra whose coordinates have a random magnitude along each axis; all of them the same along some axes.
Scene extreme_scene(std::size_t elements, std::mt19937_64& random) {
  constexpr std::array<double, 9> kMagnitudes{0,      1,     1e-300,  1e37, std::numeric_limits<float>::max(),
                                              1.7e38, 1e300, 1.7e308, 3};
  std::uniform_real_distribution<double> near(0.9, 1);
  std::array<int, 3> kinds, fixed;
  for (std::size_t k = 0; k < 3; ++k) {
    kinds[k] = static_cast<int>(random() % 4);
    fixed[k] = static_cast<int>(random() % kMagnitudes.size());
  }
  const auto coordinate = [&](std::size_t k) {
    const std::size_t any = random() % kMagnitudes.size();
    const double magnitude = kinds[k] == 0 ? 1 : kMagnitudes[kinds[k] == 1 ? static_cast<std::size_t>(fixed[k]) : any];
    const bool negative = kinds[k] != 1 && random() % 2 == 0;
    return (negative ? -1 : 1) * near(random) * magnitude;
  };
  Shape shape;
  std::vector<Vec3> x1;
  for (std::size_t o = 0; o < elements; ++o) {
    ElementSpec spec{.type = ElementType::tetrahedron, .id = static_cast<std::int64_t>(o)};
    const Vec3 at(coordinate(0), coordinate(1), coordinate(2));
    for (int v = 0; v < 4; ++v) {
      spec.vertices.push_back(static_cast<Index>(shape.positions.size()));
      shape.positions.push_back(near(random) * at);
      x1.push_back(random() % 8 == 0 ? Vec3(coordinate(0), coordinate(1), coordinate(2)) : Vec3(near(random) * at));
    }
    shape.elements.push_back(spec);
  }
  Scene scene = make_scene("extreme", shape, x1);
  scene.separation = random() % 2 == 0 ? 0 : kMagnitudes[random() % kMagnitudes.size()];
  return scene;
}

/// Calls check(scene) for scenes of a few, some, and many elements.
template <class Check>
void for_extreme_scenes(Check&& check) {
  std::mt19937_64 random(1);
  for (const std::size_t elements : {3, 20, 31, 32, 100, 3000})
    for (int round = 0; round < (elements > 1000 ? 3 : 30); ++round) {
      SCOPED_TRACE(testing::Message() << elements << " elements, round " << round);
      check(extreme_scene(elements, random));
    }
}

TEST(ExtremeCoordinates, BoundsAreFinite) {
  SerialExecutor executor;
  detail::BoundsTable table;
  for_extreme_scenes([&](const Scene& scene) {
    for (const int k : {6, 14, 16, 18, 24, 26}) {
      detail::bound_vertices(scene.step(), k, executor, table);
      for (Index v = 0; v < scene.motion.vertex_count(); ++v)
        for (int i = 0; i < 2 * table.width(); ++i) ASSERT_TRUE(std::isfinite(table.row(v)[i])) << "k " << k;
    }
  });
}

TEST(ExtremeCoordinates, TreesContainEachElementOnce) {
  const auto executor = make_thread_executor(3);
  detail::BoundsTable table;
  std::size_t infinite = 0;
  for_extreme_scenes([&](const Scene& scene) {
    detail::bound_vertices(scene.step(), 6, *executor, table);
    std::vector<Index> slots;
    detail::list_elements(scene.topology->mesh(), slots);
    const detail::ElementList list{slots, scene.topology->adjacency()};
    const auto count = static_cast<Index>(list.size());
    std::vector<detail::BuildItem> items(count);
    detail::make_items(list, table, 0, count, {}, items.data());
    for (const detail::BuildItem& item : items)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_FALSE(std::isnan(item.box.key(axis)));
        infinite += std::isinf(item.box.key(axis)) ? 1 : 0;
      }
    for (const Index leaf_size : {1, 4}) {
      detail::TreeBuilder builder;
      std::vector<detail::TreeNode> nodes(detail::tree_nodes(count, leaf_size));
      builder.build(list, table, {0, 0, count, 0}, leaf_size, nodes.data(), *executor);
      std::vector<Index> order(builder.order().begin(), builder.order().end()), all(count);
      std::sort(order.begin(), order.end());
      std::iota(all.begin(), all.end(), Index{0});
      ASSERT_EQ(order, all);
    }
  });
  EXPECT_GT(infinite, 1000u);  // otherwise the test proves nothing
}

/// Each of 60 elements is 16 times as large and as far away as the one before, so that all smaller ones are in one bin,
/// and the best split separates it alone. The depth is bounded by the ratio of the halves, which is 1 : 7 or better.
TEST(ExtremeCoordinates, TreesOfElementsOfAllSizesAreNotDeep) {
  constexpr Index kCount = 100;  // 40 of the same size, because few elements are divided at the median
  Shape shape;
  for (Index o = 0; o < kCount; ++o) {
    ElementSpec spec{.type = ElementType::tetrahedron, .id = o};
    for (const Vec3& p : {Vec3(1, 1, 1), Vec3(1.5, 1, 1), Vec3(1, 1.5, 1), Vec3(1, 1, 1.5)}) {
      spec.vertices.push_back(static_cast<Index>(shape.positions.size()));
      shape.positions.push_back(std::ldexp(1.0, 4 * std::max(0, static_cast<int>(o) - 40) - 120) * p);
    }
    shape.elements.push_back(spec);
  }
  const Scene scene = make_scene("all sizes", shape, shape.positions);
  SerialExecutor executor;
  detail::BoundsTable table;
  detail::bound_vertices(scene.step(), 6, executor, table);
  std::vector<Index> slots;
  detail::list_elements(scene.topology->mesh(), slots);
  const detail::ElementList list{slots, scene.topology->adjacency()};
  detail::TreeBuilder builder;
  std::vector<detail::TreeNode> nodes(detail::tree_nodes(kCount, 1));
  int max = 0;
  for (Index n = kCount; n > 1; n -= std::max<Index>(1, n / 8)) ++max;
  const int depth = builder.build(list, table, {0, 0, kCount, 0}, 1, nodes.data(), executor);
  EXPECT_LE(depth, max);
  EXPECT_LT(max, 60);  // otherwise the test proves nothing
}

TEST(ExtremeCoordinates, TreesFindThePairsOfBoxes) {
  const auto tree = make(describe_kdop_bvh(), {{"k", "6"}}), hash = make(describe_spatial_hash(), {{"k", "6"}}),
             boxes = make(describe_brute_force());
  const auto state = tree->make_state();
  SerialExecutor executor;
  for_extreme_scenes([&](const Scene& scene) {
    const Step step = scene.step();
    if (step.mesh().element_count() > 100) return;
    const Pairs found = run(*tree, step, *state, PairRange::every, executor), owed = run_fresh(*boxes, step);
    EXPECT_TRUE(std::includes(found.begin(), found.end(), owed.begin(), owed.end()));
    EXPECT_TRUE(found == run_fresh(*hash, step));
  });
}

}  // namespace
}  // namespace volccd::test
