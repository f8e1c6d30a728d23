#include <volccd/distributed/regions.hpp>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>

#include "distributed/rank_numbers.hpp"

namespace volccd::distributed {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Points of a coarse lattice, many of which have the same coordinates.
std::vector<Vec3> lattice_points(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points(count);
  for (Vec3& p : points)
    for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(random.below(6)) - 3;
  return points;
}

Regions divide(std::span<const Vec3> points, int ranks) {
  return Regions(points, std::vector<double>(points.size(), 1), ranks);
}

bool meets(const Region& region, const MotionBox& box) {
  return (region.low.array() < region.high.array()).all() && (box.low.array() < region.high.array()).all() &&
         (box.high.array() >= region.low.array()).all();
}

TEST(Regions, EachPointIsInExactlyOne) {
  for (const int ranks : test::kRankNumbers)
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const std::vector<Vec3> points = lattice_points(1 + seed * 7, seed);
      const Regions regions = divide(points, ranks);
      std::vector<Vec3> asked = lattice_points(200, seed + 100);  // coordinates of cuts, too
      for (const double x : {-1e308, -0.5, 0.5, 1e308, -kInfinity}) asked.push_back(Vec3(x, -x / 2, x));
      asked.back() = Vec3::Constant(-kInfinity);
      for (const Vec3& p : asked) {
        int holders = 0;
        for (int r = 0; r < ranks; ++r) holders += regions.region(r).contains(p);
        ASSERT_EQ(holders, 1) << p.transpose() << ", " << ranks << " ranks";
        ASSERT_TRUE(regions.region(regions.at(p)).contains(p));
      }
    }
}

TEST(Regions, BoxesMeetTheRegionsWithACommonPoint) {
  for (const int ranks : test::kRankNumbers)
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const Regions regions = divide(lattice_points(100, seed), ranks);
      const std::vector<Vec3> ends = lattice_points(200, seed + 100);
      for (std::size_t i = 0; i < ends.size(); i += 2) {
        const MotionBox box{ends[i].cwiseMin(ends[i + 1]), ends[i].cwiseMax(ends[i + 1])};
        std::vector<int> expected, found;
        for (int r = 0; r < ranks; ++r)
          if (meets(regions.region(r), box)) expected.push_back(r);
        for (int r = 0; r < ranks; ++r) EXPECT_EQ(regions.region(r).meets(box), meets(regions.region(r), box));
        regions.meeting(box, [&](int r) { found.push_back(r); });
        ASSERT_EQ(found, expected);
      }
    }
}

TEST(Regions, PointsOnACutAreInTheUpperRegion) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const Regions regions = divide(points, 2);
  EXPECT_EQ(regions.at({2, 0, 0}), 1);
  EXPECT_EQ(regions.at({std::nextafter(2, 0), 0, 0}), 0);
  std::vector<int> found;
  regions.meeting({{1, 0, 0}, {2, 0, 0}}, [&](int r) { found.push_back(r); });
  EXPECT_EQ(found, (std::vector<int>{0, 1}));
}

TEST(Regions, RanksWithoutPointsAreEmpty) {
  const std::vector<Vec3> same(5, Vec3(1, 2, 3)), three = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  struct Case {
    std::span<const Vec3> points;
    int filled;
  };
  for (const Case& c : {Case{{}, 1}, Case{same, 1}, Case{three, 2}}) {
    const Regions regions = divide(c.points, 16);
    int filled = 0, met = 0;
    for (int r = 0; r < regions.ranks(); ++r) filled += meets(regions.region(r), {Vec3(-9, -9, -9), Vec3(9, 9, 9)});
    regions.meeting({Vec3(-9, -9, -9), Vec3(9, 9, 9)}, [&](int) { ++met; });
    EXPECT_EQ(filled, c.filled);
    EXPECT_EQ(met, c.filled);
  }
}

TEST(Regions, DivideByWeight) {
  std::vector<Vec3> points;
  std::vector<double> weights(100, 1);
  for (int i = 0; i < 100; ++i) points.push_back(Vec3(i, 0, 0));
  weights[0] = 101;
  EXPECT_EQ(Regions(points, weights, 2).region(0).high.x(), 1);
  weights[0] = 1;
  EXPECT_EQ(Regions(points, weights, 4).region(2).low.x(), 50);
  EXPECT_EQ(Regions(points, weights, 4).region(2).high.x(), 75);
  EXPECT_EQ(Regions(points, weights, 5).region(0).high.x(), 20);
}

TEST(Regions, GreatCoordinates) {
  const double max = std::numeric_limits<double>::max();
  const std::vector<Vec3> points = {Vec3::Constant(-max), Vec3::Constant(max)};
  EXPECT_EQ(divide(points, 2).at(points[0]), 0);
  EXPECT_EQ(divide(points, 2).at(points[1]), 1);
}

TEST(Regions, RefuseNoRanks) { EXPECT_THROW(divide({}, 0), ConfigError); }

}  // namespace
}  // namespace volccd::distributed
