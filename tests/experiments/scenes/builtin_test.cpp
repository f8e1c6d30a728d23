#include <volccd/experiments/scenes/builtin.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd {
namespace {

std::map<std::int32_t, std::size_t> count_by_object(const Scene& scene, int frame) {
  SequenceCells cells;
  scene.cells(frame, cells);
  std::map<std::int32_t, std::size_t> count;
  for (const std::int32_t part : cells.objects) ++count[part];
  return count;
}

struct Box {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
};

std::map<Index, Box> element_boxes(const Mesh& mesh, const std::vector<Vec3>& x, std::int32_t object) {
  std::map<Index, Box> boxes;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.object(o) == object)
      for (const Index v : mesh.vertices(o)) {
        boxes[o].low = boxes[o].low.cwiseMin(x[v]);
        boxes[o].high = boxes[o].high.cwiseMax(x[v]);
      }
  return boxes;
}

/// Number of element pairs, one element of each object, whose boxes overlap when all sides are shrunk by `margin`.
std::size_t box_overlaps(const Scene& scene, int frame, double margin) {
  const Mesh mesh = scene_mesh(scene, frame);
  std::vector<Vec3> x;
  scene.positions(frame, x);
  const auto shots = element_boxes(mesh, x, 1), plates = element_boxes(mesh, x, 2);
  std::size_t count = 0;
  for (const auto& [a, p] : shots)
    for (const auto& [b, q] : plates)
      count += ((p.low.array() + margin) < q.high.array()).all() && ((q.low.array() + margin) < p.high.array()).all();
  return count;
}

TEST(BuiltinScene, HasTheCharacterOfAPenetrationRun) {
  const auto scene = make_builtin();
  ASSERT_EQ(scene->frames(), 9);
  const auto first = count_by_object(*scene, 0), last = count_by_object(*scene, 8);
  EXPECT_EQ(first.at(1), 250u);
  EXPECT_EQ(first.at(2), 1280u);
  EXPECT_EQ(count_by_object(*scene, 1), first) << "nothing erodes in the first motion";
  EXPECT_LT(last.at(1), first.at(1));
  EXPECT_LT(last.at(2), first.at(2) - 20);
  EXPECT_GT(last.at(1), first.at(1) / 3);
  EXPECT_GT(last.at(2), first.at(2) * 3 / 4);

  EXPECT_EQ(box_overlaps(*scene, 0, 0), 0u) << "a gap at first";
  for (int k = 1; k < 7; ++k) EXPECT_GT(box_overlaps(*scene, k, 0.1), 0u) << "frame " << k;
}

TEST(BuiltinScene, MovesAFewEdgesAStep) {
  const auto scene = make_builtin();
  std::vector<Vec3> x0, x1;
  for (int k = 0; k + 1 < scene->frames(); ++k) {
    scene->positions(k, x0);
    scene->positions(k + 1, x1);
    double max = 0;
    for (std::size_t v = 0; v < x0.size(); ++v) max = std::max(max, (x1[v] - x0[v]).norm());
    EXPECT_GT(max, 0.2);
    EXPECT_LT(max, 0.8);
  }
}

TEST(BuiltinScene, ErosionIsForGood) {
  const auto scene = make_builtin({.frames = 25});
  std::set<std::int64_t> before;
  int shrinking = 0;
  for (int k = 0; k < 25; ++k) {
    SequenceCells cells;
    scene->cells(k, cells);
    std::set<std::int64_t> ids(cells.ids.begin(), cells.ids.end());
    EXPECT_EQ(ids.size(), cells.size());
    if (k > 0) {
      EXPECT_TRUE(std::includes(before.begin(), before.end(), ids.begin(), ids.end()));
      shrinking += ids.size() < before.size();
    }
    before = std::move(ids);
  }
  EXPECT_GT(shrinking, 10);
}

TEST(BuiltinScene, LiveElementsKeepTheirVolume) {
  // The eight corner volumes of each live hexahedron stay positive in the motion.
  const auto scene = make_builtin();
  constexpr int kNeighbours[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                     {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
  for (int k = 0; k < scene->frames(); ++k) {
    const Mesh mesh = scene_mesh(*scene, k);
    std::vector<Vec3> x;
    scene->positions(k, x);
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      const auto v = mesh.vertices(o);
      for (std::size_t c = 0; c < 8; ++c) {
        const auto edge = [&](int n) { return Vec3(x[v[static_cast<std::size_t>(kNeighbours[c][n])]] - x[v[c]]); };
        EXPECT_GT(edge(0).cross(edge(1)).dot(edge(2)), 0) << "frame " << k << " element " << o;
      }
    }
  }
}

TEST(BuiltinScene, SameAgain) {
  const auto one = make_builtin(), two = make_builtin();
  std::vector<Vec3> x, y;
  SequenceCells a, b;
  for (int k = 8; k >= 0; --k) {
    one->positions(k, x);
    two->positions(k, y);
    EXPECT_EQ(x, y);
    one->cells(k, a);
    two->cells(k, b);
    EXPECT_EQ(a, b);
  }
}

/// FNV-1a over all frames but the last one. scripts/test_aarch64 builds no scenes; the number is that of AArch64, too.
TEST(BuiltinScene, HasTheSamePositionsOnEveryProcessor) {
  const auto scene = make_builtin();
  std::uint64_t hash = 14695981039346656037u;
  std::vector<Vec3> x;
  for (int frame = 0; frame + 1 < scene->frames(); ++frame) {
    scene->positions(frame, x);
    const auto* const bytes = reinterpret_cast<const unsigned char*>(x.data());
    for (std::size_t i = 0; i < x.size() * sizeof(Vec3); ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
  }
  EXPECT_EQ(hash, 0xde4063e0469e69c9u);
}

TEST(BuiltinScene, AnySize) {
  const auto small = make_builtin({.elements = 100, .frames = 2});
  EXPECT_EQ(small->frames(), 2);
  const auto large = make_builtin({.elements = 100'000, .frames = 3});
  SequenceCells cells;
  large->cells(0, cells);
  EXPECT_NEAR(static_cast<double>(cells.size()), 1e5, 1e4);
  EXPECT_THROW(make_builtin({.elements = 99}), ConfigError);
  EXPECT_THROW(make_builtin({.elements = 10'000'001}), ConfigError);
  EXPECT_THROW(make_builtin({.frames = 1}), ConfigError);
  EXPECT_THROW(make_builtin({.frames = 100'001}), ConfigError);
}

}  // namespace
}  // namespace volccd
