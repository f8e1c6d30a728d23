#include <cstring>

#include <volccd/broadphase/detail/swept_bounds.hpp>

#include "broadphase/scenes.hpp"

namespace volccd::test {
namespace {

std::vector<double> awkward_doubles() {
  std::vector<double> all{0.0,     -0.0,   1.0,     -1.0,  0.1,    -0.1,    1e-320,
                          -1e-320, 5e-324, -5e-324, 1e308, -1e308, 1.4e-45, 7e-46};
  const double max = std::numeric_limits<float>::max(), min = std::numeric_limits<float>::denorm_min();
  for (double x : {max, min, static_cast<double>(std::numeric_limits<float>::min()), 16777216.0})
    for (double sign : {-1.0, 1.0})
      for (double y : {std::nextafter(x, 0), x, std::nextafter(x, HUGE_VAL), x / 2, x * 2, x * 1.5})
        all.push_back(sign * y);
  std::mt19937_64 random(1);
  while (all.size() < 20000) {
    const std::uint64_t bits = random();
    double x;
    static_assert(sizeof x == sizeof bits);
    std::memcpy(&x, &bits, sizeof x);
    if (std::isfinite(x)) all.push_back(x);
    all.push_back(static_cast<double>(
        static_cast<float>(std::ldexp(static_cast<double>(bits), -64 + static_cast<int>(random() % 64)))));
  }
  return all;
}

TEST(FloatRounding, IsTheNearestFloatOnItsSide) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (double x : awkward_doubles()) {
    const float below = float_below(x), above = float_above(x);
    EXPECT_LE(static_cast<double>(below), x);
    EXPECT_GE(static_cast<double>(above), x);
    EXPECT_TRUE(below == infinity || static_cast<double>(std::nextafterf(below, infinity)) > x) << x;
    EXPECT_TRUE(above == -infinity || static_cast<double>(std::nextafterf(above, -infinity)) < x) << x;
  }
}

TEST(FloatRounding, ExactFloatsAndTheirRangeStay) {
  EXPECT_EQ(float_below(0.5), 0.5f);
  EXPECT_EQ(float_above(0.5), 0.5f);
  EXPECT_EQ(float_below(1e300), std::numeric_limits<float>::max());
  EXPECT_EQ(float_above(1e300), std::numeric_limits<float>::infinity());
  EXPECT_EQ(float_above(-1e300), -std::numeric_limits<float>::max());
  EXPECT_EQ(float_below(-1e300), -std::numeric_limits<float>::infinity());
  EXPECT_EQ(float_below(-1e-320), -std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(float_above(-1e-320), 0.0f);
}

float clamped(float x) {
  const float max = std::numeric_limits<float>::max();
  return std::clamp(x, -max, max);
}

template <int kK>
void expect_vertex_bounds(const Scene& scene) {
  SerialExecutor executor;
  detail::BoundsTable table;
  detail::bound_vertices(scene.step(), kK, executor, table);
  constexpr auto axes = kdop_axes<kK>();
  for (Index v = 0; v < scene.motion.vertex_count(); ++v)
    for (std::size_t i = 0; i < axes.size(); ++i) {
      double lo = std::numeric_limits<double>::infinity(), hi = -lo;
      for (int c = 0; c < scene.motion.control_points(); ++c) {
        const Vec3 p = scene.motion.point(v, c);
        // Terms with factor 0 are left out, because they would turn an overflow into NaN.
        double sum = 0;
        for (int k = 0; k < 3; ++k)
          if (axes[i][static_cast<std::size_t>(k)] != 0) sum += axes[i][static_cast<std::size_t>(k)] * p[k];
        lo = std::min(lo, sum);
        hi = std::max(hi, sum);
      }
      const float got_lo = table.row(v)[i], got_hi = table.row(v)[static_cast<std::size_t>(table.width()) + i];
      ASSERT_TRUE(std::isfinite(got_lo) && std::isfinite(got_hi)) << scene.name;
      if (axis_terms(axes[i]) < 3 && scene.separation == 0) {
        ASSERT_EQ(got_lo, clamped(float_below(lo))) << scene.name << " axis " << i;
        ASSERT_EQ(got_hi, clamped(float_above(hi))) << scene.name << " axis " << i;
      } else {
        const double by = scene.separation / 2 * std::sqrt(axis_terms(axes[i]));
        ASSERT_LE(got_lo, clamped(float_below(lo - by)));
        ASSERT_GE(got_hi, clamped(float_above(hi + by)));
      }
    }
}

TEST(VertexBounds, AreTheRoundedProjectionsLaneByLane) {
  for (const Scene& scene : scenes()) {
    expect_vertex_bounds<6>(scene);
    expect_vertex_bounds<14>(scene);
    expect_vertex_bounds<16>(scene);
    expect_vertex_bounds<18>(scene);
    expect_vertex_bounds<24>(scene);
    expect_vertex_bounds<26>(scene);
  }
}

/// Integers whose sum along an axis of three terms is small. The sum is exact in 64 bits, but the sum of two of them is
/// not exact in doubles.
TEST(VertexBounds, EncloseSumsOfThreeTermsThatCancel) {
  std::mt19937_64 random(3);
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  const auto whole = [&] { return static_cast<std::int64_t>(random() >> 11); };
  while (shape.positions.size() < 2000) {
    const std::int64_t x = whole(), y = whole(), z = (-(x + y) + static_cast<std::int64_t>(random() % 64)) / 2 * 2;
    shape.positions.push_back(Vec3(double(x), double(y), double(z)));  // z is even, and therefore a double
  }
  const Scene scene = make_scene("whole numbers", shape, shape.positions);
  SerialExecutor executor;
  detail::BoundsTable table;
  detail::bound_vertices(scene.step(), 14, executor, table);
  constexpr auto axes = kdop_axes<14>();
  int inexact = 0;
  for (Index v = 0; v < scene.motion.vertex_count(); ++v)
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Vec3 p = scene.motion.point(v, 0);
      std::int64_t exact = 0;
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const int factor = static_cast<int>(axes[i][static_cast<std::size_t>(k)]);
        exact += factor * static_cast<std::int64_t>(p[k]);
        sum += factor * p[k];
      }
      inexact += sum != static_cast<double>(exact) ? 1 : 0;
      const double lo = table.row(v)[i], hi = table.row(v)[static_cast<std::size_t>(table.width()) + i];
      ASSERT_LE(lo, static_cast<double>(exact)) << "vertex " << v << ", axis " << i;
      ASSERT_GE(hi, static_cast<double>(exact)) << "vertex " << v << ", axis " << i;
    }
  EXPECT_GT(inexact, 100);  // otherwise the test proves nothing
}

TEST(VertexBounds, RoundLikeFloatBelowAndAbove) {
  const std::vector<double> values = awkward_doubles();
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  while (shape.positions.size() < values.size()) shape.positions.push_back(Vec3::Zero());
  for (std::size_t i = 0; i < values.size(); ++i) shape.positions[i] = Vec3(values[i], -values[i], values[i] / 3);
  expect_vertex_bounds<16>(make_scene("awkward", shape, shape.positions));
}

}  // namespace
}  // namespace volccd::test
