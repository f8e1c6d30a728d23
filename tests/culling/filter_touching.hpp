// VF and EE tests that touch by construction, in exact arithmetic: coordinates are integers on a lattice, times and
// weights are powers of two, and no operation rounds.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// A random number in [low, high], nearly uniform.
  std::int64_t integer(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Vec3 vector(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }

 private:
  std::mt19937_64 engine_;
};

/// Four moving points, in the order of test_vertices().
struct TouchingTest {
  FeatureKind kind = FeatureKind::vf;
  int control_points = 2;
  std::array<std::array<Vec3, 3>, 4> points;  ///< [vertex][control point]
  double time = 0;                            ///< a time at which they touch (they may touch at other times, too)
  std::array<double, 4> weights;              ///< of the points that coincide: VF {1, w0, w1, w2}, EE {1-s, s, 1-u, u}
  /// distance of the two points at that time: 0, or exactly this value after part()
  double distance = 0;
};

/// Properties that make a case hard for floating point.
struct TouchingStyle {
  std::int64_t range = 1 << 20;  ///< lattice cells; if it is small, many points are coincident, collinear or coplanar
  int flat = 0;                  ///< this many axes are zero throughout
  int scale = 0;                 ///< coordinates times 2^scale
  double offset = 0;             ///< added to all coordinates before scaling, a multiple of 2^12
};

/// All styles of the tests.
inline const std::vector<TouchingStyle>& touching_styles() {
  static const std::vector<TouchingStyle> styles = {{1 << 20, 0, 0, 0},
                                                    {1, 0, 0, 0},
                                                    {2, 0, 0, 0},
                                                    {5, 0, -10, 0},
                                                    {1 << 10, 0, 0, 0x1p47},
                                                    {1 << 4, 0, 0, 0x1p49},
                                                    {1 << 20, 1, 0, 0},
                                                    {1 << 8, 1, 0, 0x1p47},
                                                    {1 << 20, 2, 0, 0},
                                                    {1 << 20, 0, -500, 0},
                                                    {1 << 20, 0, 480, 0},
                                                    {1 << 20, 0, -1074, 0},
                                                    {1 << 20, 0, 970, 0},
                                                    {3, 0, -1074, 0},
                                                    {3, 0, 970, 0},
                                                    {1 << 10, 0, -340, 0},
                                                    // Determinants that underflow partly.
                                                    {1 << 10, 0, -368, 0},
                                                    {1 << 10, 0, -371, 0},
                                                    {1 << 10, 0, -374, 0},
                                                    {1 << 10, 0, -377, 0}};
  return styles;
}

namespace touching_detail {

inline Vec3 bezier(const std::array<Vec3, 3>& p, int control_points, double t) {
  if (control_points == 2) return (1 - t) * p[0] + t * p[1];
  return (1 - t) * (1 - t) * p[0] + 2 * t * (1 - t) * p[1] + t * t * p[2];
}

/// Sets the last control point (the first for t = 0) so that the point is at `x` at time t = 2^-m.
inline void pass_through(std::array<Vec3, 3>& p, int control_points, double t, const Vec3& x) {
  if (t == 0) {
    p[0] = x;
  } else if (control_points == 2) {
    p[1] = (x - (1 - t) * p[0]) / t;
  } else {
    p[2] = (x - (1 - t) * (1 - t) * p[0] - 2 * t * (1 - t) * p[1]) / (t * t);
  }
}

}  // namespace touching_detail

/// A random case. All values stay below 2^50 lattice units before scaling.
inline TouchingTest touching_test(Random& random, FeatureKind kind, int control_points, const TouchingStyle& style) {
  using namespace touching_detail;
  TouchingTest test;
  test.kind = kind;
  test.control_points = control_points;
  for (auto& vertex : test.points)
    for (auto& p : vertex)
      for (int k = 0; k < 3; ++k)
        p[k] = k < style.flat ? 0 : static_cast<double>(random.integer(-style.range, style.range)) * 0x1p12;
  if (random.integer(0, 3) == 0)  // some points do not move
    for (auto& vertex : test.points) vertex[1] = vertex[2] = vertex[0];
  const auto m = random.integer(-1, control_points == 2 ? 4 : 2);
  const double t = m < 0 ? 0 : std::ldexp(1.0, -static_cast<int>(m));
  const auto at = [&](int v) { return bezier(test.points[static_cast<std::size_t>(v)], control_points, t); };
  if (kind == FeatureKind::vf) {
    const double w0 = static_cast<double>(random.integer(0, 16)) / 16;
    const double w1 = static_cast<double>(random.integer(0, static_cast<std::int64_t>((1 - w0) * 16))) / 16;
    test.weights = {1, w0, w1, 1 - w0 - w1};
    pass_through(test.points[0], control_points, t, w0 * at(1) + w1 * at(2) + (1 - w0 - w1) * at(3));
  } else {
    const double s = static_cast<double>(random.integer(0, 16)) / 16;
    const double u = std::ldexp(1.0, -static_cast<int>(random.integer(0, 4)));
    test.weights = {1 - s, s, 1 - u, u};
    const Vec3 x = (1 - s) * at(0) + s * at(1);
    pass_through(test.points[3], control_points, t, (x - (1 - u) * at(2)) / u);
  }
  test.time = t;
  if (random.integer(0, 1)) {  // in the reverse order
    test.time = 1 - t;
    for (auto& vertex : test.points) std::swap(vertex[0], vertex[static_cast<std::size_t>(control_points - 1)]);
  }
  const int turn = static_cast<int>(random.integer(0, 2));
  for (auto& vertex : test.points)
    for (auto& p : vertex) {
      const Vec3 q = p + Vec3::Constant(style.offset);
      for (int k = 0; k < 3; ++k) p[k] = std::ldexp(q[(k + turn) % 3], style.scale);
    }
  return test;
}

/// Moves the first feature away from the second by a vector of length exactly 3 * 2^exponent.
inline void part(Random& random, TouchingTest& test, int exponent) {
  Vec3 by(1, 2, 2);
  std::swap(by[0], by[random.integer(0, 2)]);
  for (int k = 0; k < 3; ++k) by[k] = std::ldexp(random.integer(0, 1) ? by[k] : -by[k], exponent);
  const std::size_t first = test.kind == FeatureKind::vf ? 1 : 2;
  for (std::size_t v = 0; v < first; ++v)
    for (auto& p : test.points[v]) p += by;
  test.distance = std::ldexp(3.0, exponent);
}

/// TestBlock::kCapacity disjoint tetrahedra: vertices 4i .. 4i+3 carry test i.
class TestBench {
 public:
  explicit TestBench(int control_points)
      : topology_(separate_tetrahedra(TestBlock::kCapacity)), motion_(topology_.mesh().vertex_count(), control_points) {
    for (Index i = 0; i < TestBlock::kCapacity; ++i) {
      const auto& features = topology_.features();
      vf_.push_back({4 * i, features.find_triangle(4 * i + 1, 4 * i + 2, 4 * i + 3)});
      FeaturePair ee{features.find_edge(4 * i, 4 * i + 1), features.find_edge(4 * i + 2, 4 * i + 3)};
      if (ee.a > ee.b) std::swap(ee.a, ee.b);
      ee_.push_back(ee);
    }
  }
  void set(std::size_t i, const TouchingTest& test) {
    for (std::size_t v = 0; v < 4; ++v)
      for (int c = 0; c < motion_.control_points(); ++c)
        motion_.set(static_cast<Index>(4 * i + v), c, test.points[v][static_cast<std::size_t>(c)]);
  }
  Step step(double separation = 0, double t_max = 1) const { return {topology_, motion_, filter_, separation, t_max}; }
  const TestBlock& block(FeatureKind kind) {
    block_.gather(step(), kind, kind == FeatureKind::vf ? vf_ : ee_);
    return block_;
  }

 private:
  Topology topology_;
  Motion motion_;
  ObjectFilter filter_;
  std::vector<FeaturePair> vf_, ee_;
  TestBlock block_;
};

}  // namespace volccd::test
