// Bounds of moving elements: they hold the element at all times, in exact arithmetic, and are apart only if disjoint.
#include <volccd/paper2011/bound_operations.hpp>
#include <volccd/paper2011/moving_obb.hpp>

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/paper2011/counted_double.hpp>

namespace volccd {
namespace {

using boost::multiprecision::cpp_rational;
using reference::MovingKdop;
using reference::MovingObb;
using reference::MovingPoint;
using Element = std::vector<MovingPoint<double>>;
using Exact3 = std::array<cpp_rational, 3>;

/// Elements of 1 to 8 vertices with sizes from 1e-6 to 1e6, at distances of up to 1e3 sizes from the origin. Some are
/// flat, straight or points, and some do not move.
Element random_element(Random& random) {
  const double size = std::pow(10, random.uniform(-6, 6)), away = size * std::pow(10, random.uniform(-3, 3));
  const Vec3 place(random.uniform(-away, away), random.uniform(-away, away), random.uniform(-away, away));
  const std::uint64_t shape = random.below(8);
  Element element(shape == 0 ? 1 : 2 + random.below(7));
  for (MovingPoint<double>& p : element)
    for (std::size_t k = 0; k < 3; ++k) {
      const bool flat = shape < 4 && k >= shape;
      p.x0[k] = place[static_cast<int>(k)] + (flat ? 0 : random.uniform(-size, size));
      p.x1[k] = shape % 2 ? p.x0[k] : p.x0[k] + random.uniform(-size, size);
    }
  return element;
}

/// A point of the element at some time, in exact arithmetic. In two of three cases it is a corner at an end of the
/// step.
Exact3 point_within(const Element& element, Random& random) {
  const cpp_rational t = random.below(3) ? cpp_rational(random.below(2)) : cpp_rational(random.uniform(0, 1));
  std::vector<cpp_rational> weights(element.size(), 0);
  if (random.below(3))
    weights[random.below(element.size())] = 1;
  else
    for (cpp_rational& w : weights) w = random.uniform(0, 1);
  cpp_rational sum = 0;
  for (const cpp_rational& w : weights) sum += w;
  Exact3 point = {0, 0, 0};
  for (std::size_t v = 0; v < element.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k) {
      const cpp_rational x0(element[v].x0[k]), x1(element[v].x1[k]);
      point[k] += weights[v] / sum * (x0 + t * (x1 - x0));
    }
  return point;
}

bool holds(const MovingKdop<double>& bounds, const Exact3& x) {
  const std::array<cpp_rational, 8> along = {x[0],        x[1],        x[2],        x[0] + x[1],
                                             x[0] + x[2], x[1] + x[2], x[0] - x[1], x[0] - x[2]};
  for (std::size_t i = 0; i < 8; ++i)
    if (along[i] < cpp_rational(bounds.low[i]) || along[i] > cpp_rational(bounds.high[i])) return false;
  return true;
}

cpp_rational determinant(const std::array<Exact3, 3>& c) {
  return c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) - c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0]) +
         c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
}

Exact3 exact(const std::array<double, 3>& x) { return {cpp_rational(x[0]), cpp_rational(x[1]), cpp_rational(x[2])}; }

/// Whether the point has coordinates in [-half, half] along the computed axes, by Cramer's rule.
bool holds(const MovingObb<double>& box, const Exact3& x) {
  const std::array<Exact3, 3> axes = {exact(box.axes[0]), exact(box.axes[1]), exact(box.axes[2])};
  const Exact3 center = exact(box.center), d = {x[0] - center[0], x[1] - center[1], x[2] - center[2]};
  const cpp_rational whole = determinant(axes);
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<Exact3, 3> replaced = axes;
    replaced[i] = d;
    if (abs(determinant(replaced) / whole) > cpp_rational(box.half[i])) return false;
  }
  return true;
}

TEST(MovingBounds, HoldTheElementAtAllTimes) {
  Random random(1);
  for (int i = 0; i < 4000; ++i) {
    const Element element = random_element(random);
    const auto kdop = reference::moving_kdop<double>(element);
    const auto obb = reference::moving_obb<double>(element);
    for (int k = 0; k < 6; ++k) {
      const Exact3 x = point_within(element, random);
      ASSERT_TRUE(holds(kdop, x)) << i;
      ASSERT_TRUE(holds(obb, x)) << i;
    }
  }
}

TEST(MovingBounds, ObbIsTightAndOrthonormal) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Element element = random_element(random);
    const auto obb = reference::moving_obb<double>(element);
    double magnitude = 0;
    for (const auto& p : element)
      for (std::size_t k = 0; k < 3; ++k) magnitude = std::max({magnitude, std::abs(p.x0[k]), std::abs(p.x1[k])});
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b)
        ASSERT_NEAR(volccd::detail::dot(obb.axes[a], obb.axes[b]), a == b ? 1 : 0, 0x1p-48);
      double low = 1e300, high = -1e300;
      for (const auto& p : element)
        for (const auto& x : {p.x0, p.x1}) {
          low = std::min(low, volccd::detail::dot(obb.axes[a], x));
          high = std::max(high, volccd::detail::dot(obb.axes[a], x));
        }
      ASSERT_NEAR(2 * obb.half[a], high - low, 1e-12 * magnitude);
    }
  }
}

/// A straight needle that moves along itself has a thin box, whatever its direction; its k-DOP need not be thin.
TEST(MovingBounds, ObbFollowsTheDirection) {
  const Vec3 direction = Vec3(1, 2, 3).normalized();
  Element needle(2);
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = direction[static_cast<int>(k)];
    needle[0].x0[k] = 0;
    needle[0].x1[k] = d;
    needle[1].x0[k] = 4 * d;
    needle[1].x1[k] = 5 * d;
  }
  auto half = reference::moving_obb<double>(needle).half;
  std::sort(half.begin(), half.end());
  EXPECT_NEAR(half[2], 2.5, 1e-9);
  EXPECT_LT(half[1], 1e-9);
}

using Corners = Eigen::Matrix<long double, 3, 8>;

Corners corners(const MovingObb<double>& box) {
  Corners result;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<std::size_t>(k);
      long double x = box.center[row];
      for (std::size_t a = 0; a < 3; ++a)
        x += ((i >> a & 1) ? 1.0L : -1.0L) * static_cast<long double>(box.half[a]) * box.axes[a][row];
      result(k, i) = x;
    }
  return result;
}

/// The greatest gap between the corners along the 15 axes, as a length; negative if they overlap along all axes.
long double gap(const MovingObb<double>& a, const MovingObb<double>& b) {
  using V = Eigen::Matrix<long double, 3, 1>;
  std::vector<V> axes;
  const auto axis = [](const std::array<double, 3>& x) { return V(x[0], x[1], x[2]); };
  for (std::size_t i = 0; i < 3; ++i) axes.insert(axes.end(), {axis(a.axes[i]), axis(b.axes[i])});
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const V c = axis(a.axes[i]).cross(axis(b.axes[j]));
      if (c.norm() > 1e-6L) axes.push_back(c.normalized());
    }
  const Corners p = corners(a), q = corners(b);
  long double best = -1e300L;
  for (const V& l : axes) {
    const auto along_p = l.transpose() * p, along_q = l.transpose() * q;
    best = std::max({best, along_q.minCoeff() - along_p.maxCoeff(), along_p.minCoeff() - along_q.maxCoeff()});
  }
  return best;
}

MovingObb<double> random_box(Random& random, const Vec3& center) {
  const auto unit = [&] { return random.uniform(-1, 1); };
  const Eigen::Quaterniond turn = Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized();
  const Eigen::Matrix3d axes = random.below(4) ? turn.toRotationMatrix() : Eigen::Matrix3d::Identity();
  MovingObb<double> box;
  for (std::size_t a = 0; a < 3; ++a) {
    box.half[a] = random.below(4) ? random.uniform(0.1, 1) : 0.5;
    for (std::size_t k = 0; k < 3; ++k) {
      box.axes[a][k] = axes(static_cast<int>(k), static_cast<int>(a));
      box.center[k] = center[static_cast<int>(k)];
    }
  }
  return box;
}

TEST(MovingBounds, ObbsAreApartIfAndOnlyIfAnAxisSeparatesTheirCorners) {
  Random random(3);
  int apart = 0, close = 0;
  for (int i = 0; i < 40000; ++i) {
    const MovingObb<double> a = random_box(random, Vec3::Zero());
    const bool grid = random.below(4) == 0;  // boxes that touch exactly
    const Vec3 place = grid ? Vec3(1, static_cast<double>(random.below(2)), static_cast<double>(random.below(2)))
                            : Vec3(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
    const MovingObb<double> b = random_box(random, place);
    const long double distance = gap(a, b);
    if (reference::apart(a, b)) {
      ++apart;
      ASSERT_GT(distance, 0) << i;
    } else {
      ASSERT_LT(distance, 1e-12L) << i;
      close += distance > -1e-12L ? 1 : 0;
    }
  }
  EXPECT_GT(apart, 5000);
  EXPECT_GT(close, 20) << "exact contacts are among them";
}

/// Two thin rods that cross at a small distance: only a cross product of their axes separates the boxes.
TEST(MovingBounds, CrossedRodsAreApartAlongAnEdgePair) {
  MovingObb<double> a, b;
  const double s = std::sqrt(0.5);
  a = {{0, 0, 0}, {{{1, 0, 0}, {0, s, s}, {0, -s, s}}}, {2, 0.1, 0.1}};
  b = {{0, 0, 0.29}, {{{0, 1, 0}, {s, 0, s}, {s, 0, -s}}}, {2, 0.1, 0.1}};
  EXPECT_TRUE(reference::apart(a, b));
  EXPECT_TRUE(reference::apart(b, a));
  b.center[2] = 0.28;  // 2 * 0.1 * sqrt(2) = 0.2828...
  EXPECT_FALSE(reference::apart(a, b));
}

TEST(MovingBounds, KdopsAreApartOnOneAxis) {
  MovingKdop<double> a;
  a.low.fill(0);
  a.high.fill(1);
  EXPECT_FALSE(reference::apart(a, a));
  for (std::size_t i = 0; i < 8; ++i) {
    MovingKdop<double> b = a;
    b.low[i] = 1;
    b.high[i] = 2;
    EXPECT_FALSE(reference::apart(a, b)) << "they touch";
    b.low[i] = 1.5;
    EXPECT_TRUE(reference::apart(a, b));
    EXPECT_TRUE(reference::apart(b, a));
  }
}

const nlohmann::json& row(const std::vector<nlohmann::json>& rows, const char* operation) {
  for (const auto& one : rows)
    if (one.at("operation") == operation) return one;
  throw std::runtime_error("no such row");
}

TEST(BoundOperations, OfAGridOfTetrahedra) {
  const Shape shape = block(ElementType::tetrahedron, 6, 6, 6);
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, jittered(shape.positions, 0.7, 5));
  const ObjectFilter filter;
  const auto rows = bound_operation_counts({topology, motion, filter}, {.tests = 300, .repetitions = 3});
  ASSERT_EQ(rows.size(), 4u);
  for (const auto& one : rows) {
    EXPECT_EQ(one.at("tests"), 300);
    EXPECT_GT(one.at("ns").get<double>(), 0);
  }
  // 8 positions with 5 sums each, and 10 of them rounded outward; 16 comparisons for each position after the first.
  EXPECT_EQ(row(rows, "kdop-update").at("additions"), 8 * 5 + 10);
  EXPECT_EQ(row(rows, "kdop-update").at("comparisons"), 7 * 16);
  EXPECT_EQ(row(rows, "kdop-test").at("max").at("comparisons"), 16);
  EXPECT_EQ(row(rows, "obb-test").at("max").at("comparisons"), 15);
  EXPECT_EQ(row(rows, "obb-test").at("paper").at("multiplications"), 81);
  EXPECT_GT(row(rows, "obb-update").at("ns"), row(rows, "kdop-update").at("ns"));
  EXPECT_TRUE(row(rows, "obb-update").at("positive").is_null());
  for (const char* test : {"kdop-test", "obb-test"}) {
    EXPECT_GT(row(rows, test).at("positive").get<double>(), 0.01) << test;
    EXPECT_LT(row(rows, test).at("positive").get<double>(), 0.99) << test;
  }
}

}  // namespace
}  // namespace volccd
