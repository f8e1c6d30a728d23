// The surface of a sequence over its frames, as a report shows it.
#include <volccd/report/surface_track.hpp>

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace volccd {
namespace {

SequenceCells two_tetrahedra() {
  SequenceCells cells;
  cells.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .object = 7});
  cells.add({.type = ElementType::tetrahedron, .vertices = {1, 2, 3, 4}, .object = 7, .id = 1});
  return cells;
}

TEST(SurfaceTrackTest, FollowsElementsThatGo) {
  SequenceCells cells = two_tetrahedra(), one;
  one.add(cells.spec(1));
  SurfaceTrack track;
  track.add(cells, 5);
  track.repeat();
  track.add(one, 5);
  ASSERT_EQ(3u, track.frames());
  EXPECT_EQ(6u, track.frame(0).size());  // the common face is inside
  EXPECT_EQ(track.frame(0).data(), track.frame(1).data());
  EXPECT_EQ(4u, track.frame(2).size());
  EXPECT_EQ(7u, track.triangles().size());
  EXPECT_EQ(6u, track.largest_frame());
  ASSERT_EQ(1u, track.objects().size());
  EXPECT_EQ(7, track.objects()[0].id);
  EXPECT_TRUE(track.objects()[0].solid);
}

TEST(SurfaceTrackTest, ClusteringKeepsTheFormAndFewerTriangles) {
  SequenceCells cells;
  std::vector<Vec3> points;
  constexpr Index n = 40;
  for (Index y = 0; y <= n; ++y)
    for (Index x = 0; x <= n; ++x) points.emplace_back(x, y, 0);
  for (Index y = 0; y < n; ++y)
    for (Index x = 0; x < n; ++x) {
      const Index a = y * (n + 1) + x;
      cells.add({.type = ElementType::quad,
                 .vertices = {a, a + 1, a + n + 2, a + n + 1},
                 .id = static_cast<std::int64_t>(cells.size())});
    }
  SurfaceTrack track;
  track.add(cells, points.size());
  const SurfaceTrack coarse = track.clustered(points, 4);
  EXPECT_EQ(2u * n * n, track.largest_frame());
  EXPECT_EQ(200u, coarse.largest_frame());  // 11 x 11 cells of the grid
  double area = 0;
  for (const std::uint32_t i : coarse.frame(0)) {
    const auto& v = coarse.triangles()[i].corners;
    area += 0.5 * (points[v[1]] - points[v[0]]).cross(points[v[2]] - points[v[0]]).norm();
  }
  EXPECT_DOUBLE_EQ(1600, area);
}

}  // namespace
}  // namespace volccd
