// Bounds of element pairs along fixed axes: verdicts compared with exact ones at any scale, common motion.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/element_kdop.hpp>
#include <volccd/numerics/kdop.hpp>

#include "csat_bench.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

/// Distance over the length of the axis by which the bounds of pair i are apart, at all control points in the same
/// order, on the best axis; negative if there is none. Coordinates are multiples of 2^-20 below 8, times a power of
/// two, so that everything but the root is exact.
double exact_gap(const PairBench& bench, Index i) {
  double best = -INFINITY;
  for (const auto& axis : kdop_axes<16>()) {
    double ahead = INFINITY, behind = INFINITY;
    for (int c = 0; c < bench.motion().control_points(); ++c) {
      std::array<double, 2> low, high;
      low.fill(INFINITY);
      high.fill(-INFINITY);
      for (Index side = 0; side < 2; ++side)
        for (Index v = 0; v < bench.vertices(); ++v) {
          const Vec3 p = bench.motion().point(bench.vertex(i, side, v), c);
          const double at = axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
          low[side] = std::min(low[side], at);
          high[side] = std::max(high[side], at);
        }
      ahead = std::min(ahead, low[1] - high[0]);
      behind = std::min(behind, low[0] - high[1]);
    }
    best = std::max(best, std::max(ahead, behind) / std::sqrt(axis_terms(axis)));
  }
  return best;
}

void set_on_lattice(PairBench& bench, Random& random, double scale) {
  const auto on_lattice = [&](double x) { return std::round(x * 0x1p20) * 0x1p-20 * scale; };
  for (Index i = 0; i < bench.pairs(); ++i) {
    const Vec3 way = random.vector(-0.5, 0.5), drift = random.vector(-2, 2);
    for (int c = 0; c < bench.motion().control_points(); ++c)
      for (Index side = 0; side < 2; ++side)
        for (Index v = 0; v < bench.vertices(); ++v) {
          const Vec3 p = random.vector(-0.5, 0.5) + (side == 0 ? -1.0 : 1.0) * way + c * drift;
          bench.set(i, side, v, c, {on_lattice(p[0]), on_lattice(p[1]), on_lattice(p[2])});
        }
  }
}

struct Counts {
  int dropped = 0, kept = 0;
};

/// Pairs that are not apart by more than the separation must stay; those that are clearly apart must go.
Counts expect_exact_verdicts(ElementType type, int control_points, double scale, double separation) {
  PairBench bench(type, control_points, 256);
  Random random(7);
  Counts counts;
  for (int round = 0; round < 4; ++round) {
    set_on_lattice(bench, random, scale);
    PairBatch batch = bench.batch(round % 2 == 1);
    run_stage(ElementKdop({}), bench.step(separation), batch);
    for (Index i = 0; i < bench.pairs(); ++i) {
      const bool kept = std::any_of(batch.pairs.begin(), batch.pairs.end(),
                                    [&](ElementPair pair) { return std::min(pair.a, pair.b) == 2 * i; });
      const double gap = exact_gap(bench, i);
      if (!(gap > separation)) {
        EXPECT_TRUE(kept) << "gap " << gap << ", separation " << separation;
      }
      if (scale < 1e37 && gap > separation + (separation + 8 * scale) * 1e-5 + 1e-35) {
        EXPECT_FALSE(kept) << "gap " << gap << ", separation " << separation;
      }
      ++(kept ? counts.kept : counts.dropped);
    }
  }
  return counts;
}

TEST(ElementKdop, DropsThePairsWhoseBoundsAreApartAtEachControlPoint) {
  for (const ElementType type : {ElementType::triangle, ElementType::tetrahedron, ElementType::hexahedron})
    for (const int control_points : {2, 3})
      for (const double separation : {0.0, 0.25}) {
        const Counts counts = expect_exact_verdicts(type, control_points, 1, separation);
        EXPECT_GT(counts.dropped, 100);
        EXPECT_GT(counts.kept, 100);
      }
}

TEST(ElementKdop, KeepsPairsWithinTheSeparationAtAnyScale) {
  for (const double scale : {0x1p-1020, 0x1p-140, 0x1p-100, 0x1p20, 0x1p125, 0x1p140, 0x1p1020})
    for (const double separation : {0.0, 0.25}) {
      const Counts counts = expect_exact_verdicts(ElementType::tetrahedron, 2, scale, separation * scale);
      if (scale > 1e-35 && scale < 1e37) {
        EXPECT_GT(counts.dropped, 100) << scale;
      }
    }
}

// Points that touch, or are as far apart as the separation, on every axis in turn.
void expect_touching_pairs_stay(double scale) {
  for (const auto& axis : kdop_axes<16>())
    for (const double separation : {0.0, 0.7}) {
      PairBench bench(ElementType::tetrahedron, 2, 1);
      const Vec3 along = Vec3(axis[0], axis[1], axis[2]) / axis_terms(axis);
      const double length = std::sqrt(axis_terms(axis));
      for (int c = 0; c < 2; ++c)
        for (Index side = 0; side < 2; ++side)
          for (Index v = 0; v < 4; ++v) {
            const double out = v == 0 ? 0 : 0.1 * v;
            const double height = side == 0 ? -out : out + separation * length * (1 - 1e-14);
            bench.set(0, side, v, c, scale * (Vec3(1.1, 2.3, 3.7) + 100.3 * c * along + height * along));
          }
      PairBatch batch = bench.batch();
      run_stage(ElementKdop({}), bench.step(scale * separation), batch);
      EXPECT_EQ(batch.size(), 1u) << axis[0] << axis[1] << axis[2] << ", separation " << separation;
    }
}

TEST(ElementKdop, KeepsPairsThatTouch) {
  expect_touching_pairs_stay(1);
  for (int i = 0; i < 40; ++i) expect_touching_pairs_stay(std::ldexp(1 + 0.013 * i, -147 + i % 8));
}

TEST(ElementKdop, CommonMotionDoesNotMatter) {
  PairBench bench(ElementType::tetrahedron, 2, 1);
  for (int c = 0; c < 2; ++c)
    for (Index side = 0; side < 2; ++side)
      for (Index v = 0; v < 4; ++v)
        bench.set(0, side, v, c, Vec3(50.0 * c + 2 * side, v == 1, v == 2) + Vec3(v == 3, 0, 0) / 2);
  PairBatch batch = bench.batch();
  run_stage(ElementKdop({}), bench.step(), batch);
  EXPECT_EQ(batch.size(), 0u);
}

// Bounds are kept in a cache, where elements whose slots differ by a multiple of 2^14 replace each other.
TEST(ElementKdop, TheOrderOfPairsDoesNotMatter) {
  constexpr Index kEntries = Index{1} << 14;
  PairBench bench(ElementType::tetrahedron, 2, kEntries);
  const ElementKdop stage({});
  const auto state = stage.make_state();
  SerialExecutor executor;
  for (const double distance : {4.0, 0.0, 4.0}) {  // between consecutive elements
    for (Index o = 0; o < 2 * kEntries; ++o)
      for (int c = 0; c < 2; ++c)
        for (Index v = 0; v < 4; ++v)
          bench.set(o / 2, o % 2, v, c, Vec3(distance * o + (v == 3 ? 0.5 : 0), v == 1, v == 2));
    stage.prepare(bench.step(), *state, executor);
    PairBatch batch;
    for (Index o = 0; o < kEntries; o += 7)
      batch.pairs.insert(batch.pairs.end(),
                         {{o, o + 1}, {o, o + kEntries}, {o + kEntries, o + 1}, {o, o + 1}, {o + kEntries, o}});
    batch.masks.resize(batch.pairs.size());
    const std::size_t all = batch.size();
    stage.run(bench.step(), *state, 0, batch);
    EXPECT_EQ(batch.size(), distance == 0 ? all : 0);
  }
}

}  // namespace
}  // namespace volccd::test
