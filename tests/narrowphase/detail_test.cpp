// The parts of the elementary tests: rounding bounds, roots, distances.
#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/closest_points.hpp>
#include <volccd/narrowphase/cubic/detail/polynomial_roots.hpp>
#include <volccd/narrowphase/detail/coplanarity_block.hpp>
#include <volccd/numerics/double_double.hpp>

#include "oracle.hpp"
#include "query_set.hpp"

namespace volccd::test {
namespace {

using detail::CoplanarityBlock;
using detail::CoplanarityCubic;
__extension__ using Integer = __int128;

/// Coefficients of det(d1, d2, d3)(t) exactly, for coordinates that are integers below 2^31.
std::array<Integer, 4> exact_coefficients(const Query& q) {
  const auto d = [&](std::size_t time, std::size_t i, int k) {
    return static_cast<Integer>(q[4 * time + i][k]) - static_cast<Integer>(q[4 * time][k]);
  };
  std::array<Integer, 4> b = {0, 0, 0, 0};
  static constexpr int permutations[6][4] = {{0, 1, 2, 1},  {1, 2, 0, 1},  {2, 0, 1, 1},
                                             {0, 2, 1, -1}, {2, 1, 0, -1}, {1, 0, 2, -1}};
  for (std::size_t mask = 0; mask < 8; ++mask)
    for (const auto& p : permutations)
      b[(mask & 1) + (mask >> 1 & 1) + (mask >> 2)] +=
          p[3] * d(mask & 1, 1, p[0]) * d(mask >> 1 & 1, 2, p[1]) * d(mask >> 2, 3, p[2]);
  return b;
}

std::vector<Query> integer_queries(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Query> queries(n);
  for (std::size_t i = 0; i < n; ++i) {
    // Large common offsets make differences cancel. Every third query is nearly flat, so that determinants cancel.
    const auto range = std::uint64_t{1} << (2 + i % 28);
    for (Vec3& p : queries[i]) {
      for (int k = 0; k < 3; ++k) p[k] = static_cast<double>(random.below(range));
      if (i % 3 == 0) p[2] = p[0] + p[1] + static_cast<double>(random.below(2));
    }
  }
  return queries;
}

TEST(Coplanarity, ErrorBoundsHold) {
  const std::vector<Query> queries = integer_queries(20000, 31);
  const QuerySet set(FeatureKind::vf, queries);
  TestBlock tests;
  CoplanarityBlock block;
  double worst = 0;
  static constexpr double binomial[] = {1, 3, 3, 1};
  for (std::size_t i = 0; i < queries.size(); ++i) {
    tests.gather(set.step(), FeatureKind::vf, std::span(set.pairs()).subspan(i, 1));
    block.compute(tests, false);
    const CoplanarityCubic cubic = block.cubic(0);
    const CoplanarityCubic refined =
        detail::refined_coplanarity(detail::test_points(set.step().motion, tests.vertices(0)), 1);
    const std::array<Integer, 4> exact = exact_coefficients(queries[i]);
    ASSERT_LT(refined.error, std::max(cubic.error, 1e-200));
    for (std::size_t k = 0; k < 4; ++k) {
      const Real error = std::abs(static_cast<Real>(static_cast<Integer>(cubic.b[k]) - exact[k]));
      ASSERT_LE(error, Real(binomial[k]) * cubic.error);
      worst = std::max(worst, static_cast<double>(error / (binomial[k] * cubic.error)));
      // The value is rounded once, and is therefore the nearest double except for ties.
      ASSERT_LE(std::abs(static_cast<Real>(static_cast<Integer>(refined.b[k]) - exact[k])),
                Real(kUnitRoundoff) * std::abs(static_cast<Real>(exact[k])));
      if (exact[k] == 0) {
        ASSERT_LE(std::abs(refined.b[k]), refined.error);
      }
    }
  }
  EXPECT_GT(worst, 0.01) << "the queries do not strain the bound";
}

TEST(Coplanarity, ClosedTestsHaveNoRoot) {
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::vector<Query> queries = integer_queries(30000, 32);
    const QuerySet set(kind, queries);
    TestBlock tests;
    CoplanarityBlock block;
    std::size_t closed = 0;
    for (std::size_t i = 0; i < queries.size(); i += 50) {
      tests.gather(set.step(), kind, std::span(set.pairs()).subspan(i, 50));
      block.compute(tests, false);
      for (std::size_t j = 0; j < 50; ++j) {
        if (block.open(j)) continue;
        ++closed;
        const std::array<Integer, 4> b = exact_coefficients(queries[i + j]);
        const bool positive = b[0] > 0 && b[1] > 0 && b[2] > 0 && b[3] > 0;
        const bool negative = b[0] < 0 && b[1] < 0 && b[2] < 0 && b[3] < 0;
        ASSERT_TRUE(positive || negative);
      }
    }
    EXPECT_GT(closed, 1000u);
  }
}

TEST(Coplanarity, AxisTestClosesOnlySeparatedTests) {
  Random random(33);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::vector<Query> queries(20000);
    for (Query& q : queries)
      for (Vec3& p : q)
        for (int k = 0; k < 3; ++k) p[k] = static_cast<double>(random.below(6));
    const QuerySet set(kind, queries);
    TestBlock tests;
    std::size_t separated = 0;
    for (std::size_t i = 0; i < queries.size(); i += 64) {
      CoplanarityBlock with, without;
      const auto batch = std::span(set.pairs()).subspan(i, std::min<std::size_t>(64, queries.size() - i));
      tests.gather(set.step(), kind, batch);
      with.compute(tests, true);
      without.compute(tests, false);
      for (std::size_t j = 0; j < batch.size(); ++j) {
        const std::size_t split = kind == FeatureKind::vf ? 1 : 2;
        bool apart = false;
        for (int k = 0; k < 3 && !apart; ++k)
          for (const double sign : {1.0, -1.0}) {
            bool both = true;
            for (std::size_t time = 0; time < 2; ++time)
              for (std::size_t a = 0; a < split; ++a)
                for (std::size_t b = split; b < 4; ++b)
                  both = both && sign * (queries[i + j][4 * time + b][k] - queries[i + j][4 * time + a][k]) > 0;
            apart = apart || both;
          }
        ASSERT_EQ(with.open(j), without.open(j) && !apart);
        separated += apart ? 1 : 0;
      }
    }
    EXPECT_GT(separated, 500u);
  }
}

TEST(DoubleDouble, ProductsAndSumsAreExact) {
  Random random(34);
  for (int i = 0; i < 100000; ++i) {
    const double a = random.uniform(-1, 1) * std::ldexp(1.0, static_cast<int>(random.below(60)) - 30);
    const double b = random.uniform(-1, 1) * std::ldexp(1.0, static_cast<int>(random.below(60)) - 30);
    const detail::DoubleDouble s = detail::exact_sum(a, b), p = detail::exact_product(a, b);
    ASSERT_EQ(s.high, a + b);
    ASSERT_EQ(p.high, a * b);
    ASSERT_EQ(p.low, std::fma(a, b, -p.high));
    // Knuth's theorem, checked by recovering the smaller operand (Dekker).
    const double large = std::abs(a) >= std::abs(b) ? a : b, small = std::abs(a) >= std::abs(b) ? b : a;
    ASSERT_EQ(s.low, small - (s.high - large));
  }
}

TEST(PolynomialRoots, QuadraticFindsKnownRoots) {
  Random random(35);
  for (int i = 0; i < 50000; ++i) {
    // (t - r1)(t - r2) in Bernstein form; the coefficients are values of the blossom.
    double r1 = random.uniform(-0.5, 1.5), r2 = random.uniform(-0.5, 1.5);
    if (i % 5 == 0) r1 = 0;
    if (i % 7 == 0) r2 = 1;
    if (r1 > r2) std::swap(r1, r2);
    const double scale = random.uniform(0.1, 10) * (i % 2 ? 1 : -1);
    std::array<double, 2> roots;
    const int count = detail::quadratic_roots(scale * r1 * r2, scale * (r1 * r2 - 0.5 * (r1 + r2)),
                                              scale * (1 - r1) * (1 - r2), roots);
    std::vector<double> expected;
    for (const double r : {r1, r2})
      if (r >= 0 && r <= 1) expected.push_back(r);
    if (std::abs(r1 - r2) < 1e-6 ||
        std::min(std::abs(r1), std::abs(r1 - 1)) * std::min(std::abs(r2), std::abs(r2 - 1)) < 1e-12) {
      if (r1 != 0 && r2 != 1) continue;  // rounding may move it out of the interval
    }
    ASSERT_EQ(count, static_cast<int>(expected.size())) << r1 << " " << r2;
    for (std::size_t k = 0; k < expected.size(); ++k) ASSERT_NEAR(roots[k], expected[k], 1e-9) << r1 << " " << r2;
  }
}

TEST(PolynomialRoots, MonotonePiecesAndRootsOfKnownCubics) {
  Random random(36);
  for (int i = 0; i < 20000; ++i) {
    std::array<double, 3> r = {random.uniform(0.02, 0.98), random.uniform(0.02, 0.98), random.uniform(0.02, 0.98)};
    std::sort(r.begin(), r.end());
    if (r[1] - r[0] < 1e-3 || r[2] - r[1] < 1e-3) continue;
    // (t-r0)(t-r1)(t-r2), with the binomials included.
    CoplanarityCubic f;
    f.error = 1e-18;
    f.b = {-r[0] * r[1] * r[2], (1 - r[0]) * r[1] * r[2] + r[0] * (1 - r[1]) * r[2] + r[0] * r[1] * (1 - r[2]),
           -(r[0] * (1 - r[1]) * (1 - r[2]) + (1 - r[0]) * r[1] * (1 - r[2]) + (1 - r[0]) * (1 - r[1]) * r[2]),
           (1 - r[0]) * (1 - r[1]) * (1 - r[2])};
    const detail::MonotonePieces pieces = detail::monotone_pieces(f);
    ASSERT_EQ(pieces.count, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_GT(r[k], pieces.cut[k]);
      ASSERT_LT(r[k], pieces.cut[k + 1]);
      ASSERT_NEAR(detail::bracketed_root(f, pieces.cut[k], pieces.cut[k + 1]), r[k], 1e-9);
      const std::array<double, 2> stretch = detail::zero_stretch(f, pieces.cut[k], pieces.cut[k + 1]);
      ASSERT_LE(stretch[0], stretch[1]);
      ASSERT_LE(stretch[0], r[k] + 1e-12);
      ASSERT_GE(stretch[1], r[k] - 1e-12);
      ASSERT_LT(stretch[1] - stretch[0], 1e-8);
    }
  }
}

/// Slivers, parallel edges, features without extent, and ordinary features, at one time.
detail::Differences awkward(Random& random, int number) {
  detail::Differences d;
  for (Vec3& p : d)
    for (int k = 0; k < 3; ++k) p[k] = random.uniform(-1, 1);
  const double thin = std::ldexp(1.0, -static_cast<int>(random.below(60)));
  if (number % 4 == 1) d[2] = d[0] + random.uniform() * (d[1] - d[0]) + thin * d[2];  // sliver
  if (number % 4 == 2) d[2] = d[1] + random.uniform(-1, 1) * d[0] + thin * d[2];      // nearly parallel edges
  if (number % 4 == 3) d[1] = d[2] + thin * d[1];                                     // short edge
  if (number % 8 >= 4) {
    // The features touch, or nearly touch.
    const Vec3 touch = random.uniform() * d[1] + thin * d[0];
    for (Vec3& p : d) p -= touch;
  }
  return d;
}

TEST(ClosestPoints, DistanceAgreesWithVoronoiRegions) {
  Random random(37);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (int i = 0; i < 100000; ++i) {
      const detail::Differences d = awkward(random, i);
      const detail::ClosestPoints c = detail::closest_points(kind, d);
      const Query q = {Vec3(0, 0, 0), d[0], d[1], d[2], Vec3(0, 0, 0), d[0], d[1], d[2]};
      const Real exact = distance_at(kind, q, 0);
      // The result is a distance of two points of the features, and therefore never too small. The judge must find no
      // smaller distance; for slivers and nearly parallel edges its own rounding may make its distance too large.
      Real sum0 = 0, sum1 = 0;
      Point first = Point::Zero(), second = Point::Zero();
      for (std::size_t p = 0; p < 4; ++p) {
        const bool in_first = p < (kind == FeatureKind::vf ? 1u : 2u);
        (in_first ? first : second) += Real(c.weights[p]) * q[p].cast<Real>();
        (in_first ? sum0 : sum1) += Real(c.weights[p]);
      }
      ASSERT_NEAR(static_cast<double>(sum0), 1, 1e-15);
      ASSERT_NEAR(static_cast<double>(sum1), 1, 1e-15);
      ASSERT_NEAR(std::sqrt(c.squared_distance), static_cast<double>((first - second).norm()), 1e-15) << i;
      ASSERT_LE(std::sqrt(c.squared_distance), static_cast<double>(exact) + 1e-13) << i;
      for (const double w : c.weights) ASSERT_GE(w, 0);
      Real distance = 1e-13L;
      const double size =
          std::max({d[0].cwiseAbs().maxCoeff(), d[1].cwiseAbs().maxCoeff(), d[2].cwiseAbs().maxCoeff()});
      for (; distance < 1; distance *= 10) {
        if (detail::clearly_apart(kind, d, static_cast<double>(distance), size)) {
          ASSERT_GT(exact, distance) << i;
        }
      }
    }
}

}  // namespace
}  // namespace volccd::test
