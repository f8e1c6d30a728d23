#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>
#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/culling/filters/coplanarity_filter.hpp>
#include <volccd/culling/filters/csat_filter.hpp>
#include <volccd/culling/filters/feature_kdop_filter.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/numerics/kdop.hpp>

#include "culling/filter_touching.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

using Rational = boost::multiprecision::cpp_rational;

struct NamedFilter {
  std::string name;
  std::unique_ptr<FeatureFilter> filter;
};

NamedFilter make(const StageDescriptor<FeatureFilter>& stage, const OptionValues& options) {
  std::string name = stage.name;
  for (const auto& [key, value] : options) name += " " + key + "=" + value;
  return {name, stage.make(options)};
}

std::vector<NamedFilter> all_filters() {
  std::vector<NamedFilter> filters;
  for (const char* k : {"6", "14", "16", "18", "24", "26"})
    for (const char* bounds : {"swept", "relative"})
      filters.push_back(make(describe_feature_kdop_filter(), {{"k", k}, {"bounds", bounds}}));
  filters.push_back(make(describe_coplanarity_filter(), {}));
  for (const char* axes : {"first", "ends", "wide"}) filters.push_back(make(describe_csat_filter(), {{"axes", axes}}));
  return filters;
}

std::vector<std::uint8_t> run(const FeatureFilter& filter, const Step& step, const TestBlock& block) {
  std::vector<std::uint8_t> keep(block.padded_size(), 1);
  test::run_stage(filter, step, block, keep);
  return keep;
}

/// Fills the bench with cases of one style and returns them.
std::vector<TouchingTest> fill(TestBench& bench, Random& random, FeatureKind kind, int control_points,
                               const TouchingStyle& style, int exponent = -9999) {
  std::vector<TouchingTest> tests;
  for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
    tests.push_back(touching_test(random, kind, control_points, style));
    if (exponent > -9999) part(random, tests.back(), exponent);
    bench.set(i, tests.back());
  }
  return tests;
}

/// Calls body(kind, control points, style, round) for all combinations.
template <class Body>
void for_each_style(int rounds, Body&& body) {
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const auto& style : touching_styles())
        for (int round = 0; round < rounds; ++round) body(kind, control_points, style, round);
}

std::array<Rational, 3> position(const TouchingTest& test, std::size_t v) {
  const Rational t(test.time), r = 1 - t;
  std::array<Rational, 3> x;
  for (int k = 0; k < 3; ++k) {
    const auto& p = test.points[v];
    const std::size_t axis = static_cast<std::size_t>(k);
    if (test.control_points == 2)
      x[axis] = r * Rational(p[0][k]) + t * Rational(p[1][k]);
    else
      x[axis] = r * r * Rational(p[0][k]) + 2 * r * t * Rational(p[1][k]) + t * t * Rational(p[2][k]);
  }
  return x;
}

TEST(FilterTouching, CasesTouchInRationalArithmetic) {
  Random random(1);
  for_each_style(8, [&](FeatureKind kind, int control_points, const TouchingStyle& style, int round) {
    TouchingTest test = touching_test(random, kind, control_points, style);
    if (round % 2 == 0 && style.scale == 0) part(random, test, 12);
    const std::size_t first = kind == FeatureKind::vf ? 1 : 2;
    Rational square = 0;
    std::array<std::array<Rational, 3>, 4> x;
    for (std::size_t v = 0; v < 4; ++v) x[v] = position(test, v);
    for (std::size_t k = 0; k < 3; ++k) {
      Rational gap = 0;
      for (std::size_t v = 0; v < 4; ++v) gap += (v < first ? 1 : -1) * Rational(test.weights[v]) * x[v][k];
      square += gap * gap;
    }
    EXPECT_EQ(square, Rational(test.distance) * Rational(test.distance));
    EXPECT_TRUE(test.time >= 0 && test.time <= 1);
  });
}

TEST(FilterConservative, TouchingTestsAreKept) {
  const auto filters = all_filters();
  Random random(2);
  for_each_style(24, [&](FeatureKind kind, int control_points, const TouchingStyle& style, int) {
    TestBench bench(control_points);
    const auto tests = fill(bench, random, kind, control_points, style);
    const TestBlock& block = bench.block(kind);
    for (const auto& [name, filter] : filters) {
      const auto keep = run(*filter, bench.step(), block);
      for (std::size_t i = 0; i < tests.size(); ++i)
        ASSERT_TRUE(keep[i]) << name << (kind == FeatureKind::vf ? " VF " : " EE ") << control_points << " range "
                             << style.range << " scale " << style.scale << " flat " << style.flat;
    }
  });
}

TEST(FilterConservative, TouchingByTMaxIsKept) {
  const auto filters = all_filters();
  Random random(3);
  for_each_style(8, [&](FeatureKind kind, int control_points, const TouchingStyle& style, int round) {
    TestBench bench(control_points);
    const auto tests = fill(bench, random, kind, control_points, style);
    const TestBlock& block = bench.block(kind);
    // The whole block has one t_max. Tests that touch by then must be kept; the others may be dropped.
    const double t_max = round % 2 ? tests[0].time : random.uniform(0, 1);
    for (const auto& [name, filter] : filters) {
      const auto keep = run(*filter, bench.step(0, t_max), block);
      for (std::size_t i = 0; i < tests.size(); ++i) {
        if (tests[i].time <= t_max) {
          ASSERT_TRUE(keep[i]) << name << " t_max " << t_max << " time " << tests[i].time;
        }
      }
    }
  });
}

TEST(FilterConservative, WithinTheSeparationIsKept) {
  const auto filters = all_filters();
  Random random(4);
  for_each_style(8, [&](FeatureKind kind, int control_points, const TouchingStyle& style, int round) {
    if (style.scale < -600 || style.scale > 600) return;  // offsets would round
    TestBench bench(control_points);
    const auto tests = fill(bench, random, kind, control_points, style, style.scale + 4 + 3 * (round % 8));
    const TestBlock& block = bench.block(kind);
    for (const auto& [name, filter] : filters) {
      const auto keep = run(*filter, bench.step(tests[0].distance), block);
      for (std::size_t i = 0; i < tests.size(); ++i) ASSERT_TRUE(keep[i]) << name << " at " << tests[i].distance;
    }
  });
}

// The plane x + y + z = const through the contact separates the features except at the contact, and all four points are
// rounded differently.
TEST(FilterConservative, GrazingAlongDiagonalsIsKept) {
  const auto filters = all_filters();
  Random random(9);
  const auto big = [&] {
    return static_cast<double>(random.integer(std::int64_t{1} << 51, (std::int64_t{1} << 53) - (1 << 22)));
  };
  for (int round = 0; round < 2000; ++round) {
    const auto kind = round % 2 ? FeatureKind::vf : FeatureKind::ee;
    TestBench bench(2);
    for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
      const Vec3 contact(big(), big(), big()), up = Vec3::Constant(static_cast<double>(random.integer(1, 1 << 20)));
      const auto x = static_cast<double>(random.integer(-1000, 1000)),
                 y = static_cast<double>(random.integer(-1000, 1000));
      const Vec3 along(x, y, -x - y), across(y, -x - y, x);
      const std::array<Vec3, 4> points =
          kind == FeatureKind::vf
              ? std::array<Vec3, 4>{contact, contact + along, contact - along, contact + up}
              : std::array<Vec3, 4>{contact + along, contact - along, contact + across, contact - across};
      TouchingTest test;
      const int flip = static_cast<int>(random.integer(0, 7));
      for (std::size_t v = 0; v < 4; ++v) {
        Vec3 p = points[v];
        for (int k = 0; k < 3; ++k)
          if (flip >> k & 1) p[k] = -p[k];
        test.points[v] = {p, p, p};
      }
      bench.set(i, test);
    }
    for (const auto& [name, filter] : filters)
      for (const double t_max : {1.0, 0.3}) {
        const auto keep = run(*filter, bench.step(0, t_max), bench.block(kind));
        for (const auto k : keep) ASSERT_TRUE(k) << name << " t_max " << t_max;
      }
  }
}

/// Two features that meet at the end of the step, apart from rounding; at the start they are smaller by a factor of
/// `size`, and apart. One of the four points is farther away than the others by a factor of up to `reach`.
TouchingTest growing_test(Random& random, FeatureKind kind, int control_points, double size, double reach) {
  const Vec3 at = random.vector(-1, 1) / (random.integer(0, 1) == 0 ? 1 : reach);
  const Vec3 u = random.vector(-1, 1), w = random.vector(-1, 1);
  const auto length = [&] { return random.uniform(0.2, 1) * (random.integer(0, 3) == 0 ? 1 : 1 / reach); };
  std::array<Vec3, 4> points;
  if (kind == FeatureKind::vf) {
    std::array<Vec3, 3> corners{at + u / reach, at + w / reach, at - length() * (u + w)};
    std::rotate(corners.begin(), corners.begin() + random.integer(0, 2), corners.end());
    points = {at, corners[0], corners[1], corners[2]};
  } else {
    points = {at - length() * u, at + length() * u, at - length() * w, at + length() * w};
  }
  const Vec3 apart = random.uniform(0.5, 1) * u.cross(w);
  TouchingTest test;
  for (std::size_t v = 0; v < 4; ++v) {
    const bool first = v < (kind == FeatureKind::vf ? 1u : 2u);
    for (int c = 0; c < control_points; ++c)
      test.points[v][static_cast<std::size_t>(c)] =
          c == control_points - 1 ? points[v] : Vec3(size * (first ? Vec3(points[v] + apart) : points[v]));
  }
  return test;
}

bool touches(const TouchingTest& test, FeatureKind kind, int control_points) {
  TestMotion motion{kind, control_points, {}};
  for (std::size_t v = 0; v < 4; ++v) motion.points[v] = test.points[v][0].data();
  return exact_first_touch(motion).touches;
}

TEST(FilterConservative, GrazingTestsThatGrowAreKept) {
  const auto filters = all_filters();
  Random random(11);
  int touching = 0;
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const double size : {0x1p-4, 0x1p-10, 0x1p-20})
        for (const double reach : {1.0, 0x1p10, 0x1p20})
          for (int round = 0; round < 2; ++round) {
            TestBench bench(control_points);
            std::vector<TouchingTest> tests;
            for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
              tests.push_back(growing_test(random, kind, control_points, size, reach));
              bench.set(i, tests.back());
            }
            std::vector<std::string> dropped(tests.size());
            for (const auto& [name, filter] : filters) {
              const auto keep = run(*filter, bench.step(), bench.block(kind));
              for (std::size_t i = 0; i < tests.size(); ++i)
                if (!keep[i]) dropped[i] += name + ", ";
            }
            for (std::size_t i = 0; i < tests.size(); ++i) {
              const bool touch = touches(tests[i], kind, control_points);
              touching += touch ? 1 : 0;
              ASSERT_TRUE(dropped[i].empty() || !touch) << dropped[i] << "size " << size << ", reach " << reach;
            }
          }
  EXPECT_GT(touching, 1000);
}

// Along an axis of the 26-DOP, the features are nearer to each other than the separation, by very little.
TEST(FilterConservative, JustWithinTheSeparationAlongAnAxisIsKept) {
  const auto filters = all_filters();
  Random random(12);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const auto& axis : kdop_axes<26>()) {
        const double separation = random.uniform(0.1, 1);
        const Vec3 way = Vec3(axis[0], axis[1], axis[2]).normalized();
        TestBench bench(control_points);
        for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
          const Vec3 motion = random.vector(-1, 1);
          const std::size_t nearest[2] = {0, kind == FeatureKind::vf ? 1u : 2u};
          TouchingTest test;
          for (std::size_t v = 0; v < 4; ++v) {
            const bool first = v < nearest[1], near = v == nearest[0] || v == nearest[1];
            Vec3 p = near ? Vec3(0, 0, 0) : random.vector(-1, 1);
            p += ((first ? -1 : 1) * (near ? 0 : random.uniform(0, 1)) - p.dot(way)) * way;
            if (!first) p += separation * (1 - 1e-12) * way;
            for (int c = 0; c < control_points; ++c) test.points[v][static_cast<std::size_t>(c)] = p + c * motion;
          }
          bench.set(i, test);
        }
        for (const auto& [name, filter] : filters)
          for (const double t_max : {1.0, 0.3})
            for (const auto keep : run(*filter, bench.step(separation, t_max), bench.block(kind)))
              ASSERT_TRUE(keep) << name << ", axis " << axis[0] << axis[1] << axis[2];
      }
}

/// Random tests of the size 1 whose features are `distance` apart along x, and move by up to `motion`.
void fill_apart(TestBench& bench, Random& random, FeatureKind kind, int control_points, double distance,
                double motion) {
  for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
    TouchingTest test;
    const Vec3 common = random.vector(-5, 5);
    for (std::size_t v = 0; v < 4; ++v) {
      const bool second = v >= (kind == FeatureKind::vf ? 1u : 2u);
      const Vec3 x = random.vector(0, 1) + (second ? Vec3(1 + distance, 0, 0) : Vec3(0, 0, 0));
      for (int c = 0; c < control_points; ++c)
        test.points[v][static_cast<std::size_t>(c)] = x + c * common + random.vector(-motion, motion);
    }
    bench.set(i, test);
  }
}

double dropped_share(const FeatureFilter& filter, FeatureKind kind, int control_points, double distance, double motion,
                     const Step& like) {
  TestBench bench(control_points);
  Random random(5);
  int dropped = 0, all = 0;
  for (int round = 0; round < 20; ++round) {
    fill_apart(bench, random, kind, control_points, distance, motion);
    for (const auto keep : run(filter, bench.step(like.separation, like.t_max), bench.block(kind))) {
      dropped += keep == 0;
      ++all;
    }
  }
  return static_cast<double>(dropped) / all;
}

TEST(FilterEffect, DropsWhatIsApart) {
  const TestBench like(2);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      const auto share = [&](const NamedFilter& f, double separation = 0, double t_max = 1) {
        return dropped_share(*f.filter, kind, control_points, 0.3, 0.1, like.step(separation, t_max));
      };
      for (const char* k : {"6", "14", "16", "18", "24", "26"}) {
        const auto relative = make(describe_feature_kdop_filter(), {{"k", k}, {"bounds", "relative"}});
        const auto swept = make(describe_feature_kdop_filter(), {{"k", k}, {"bounds", "swept"}});
        EXPECT_EQ(share(relative), 1) << k;
        EXPECT_EQ(share(relative, 0.09), 1) << k;
        EXPECT_EQ(share(relative, 0, 0.5), 1) << k;
        EXPECT_LT(share(swept), 0.9) << "common motion is no obstacle for these";
        EXPECT_GT(share(swept, 0, 0.01), share(swept)) << k;
      }
      EXPECT_GT(share(make(describe_csat_filter(), {{"axes", "wide"}})), 0.7);
      EXPECT_GT(share(make(describe_csat_filter(), {{"axes", "ends"}})), 0.3);
      EXPECT_GT(share(make(describe_csat_filter(), {{"axes", "first"}})), 0.2);
      const auto coplanarity = make(describe_coplanarity_filter(), {});
      EXPECT_GT(share(coplanarity), 0.2);
      EXPECT_GT(share(coplanarity, 0.01), 0.15);
      EXPECT_LE(share(coplanarity, 0.01), share(coplanarity));
      EXPECT_EQ(share(coplanarity, 100), 0);
      EXPECT_GE(share(coplanarity, 0, 0.1), share(coplanarity));
    }
}

/// Tests of a block that select() takes out.
std::size_t taken_out(const FeatureFilter& filter, const Step& step, const TestBlock& block) {
  const auto state = prepared_to_select(filter, step);
  std::vector<FeaturePair> tests(block.pairs().begin(), block.pairs().end());
  return tests.size() - filter.select(step, *state, 0, block.kind(), tests);
}

TEST(FilterSelect, FixedAxesNeedNoCoordinates) {
  Random random(12);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      TestBench bench(control_points);
      fill_apart(bench, random, kind, control_points, 0.3, 0.1);
      const TestBlock& block = bench.block(kind);
      for (const char* k : {"6", "14", "16", "18", "24", "26"})
        for (const std::string bounds : {"swept", "relative"}) {
          const auto [name, filter] = make(describe_feature_kdop_filter(), {{"k", k}, {"bounds", bounds}});
          // The axes of k = 16 must not stand in for others.
          const bool selects = bounds == "relative" && std::stoi(k) >= 16;
          for (const double separation : {0.0, 0.09})
            EXPECT_EQ(taken_out(*filter, bench.step(separation), block), selects ? block.size() : 0)
                << name << " separation " << separation;
          EXPECT_EQ(taken_out(*filter, bench.step(5), block), 0) << name;
        }
    }
}

TEST(FilterEffect, HoldsAcrossScales) {
  TestBench bench(2);
  for (const auto& [name, filter] : all_filters())
    for (const double scale : {0x1p-300, 1.0, 0x1p300}) {
      Random random(6);
      int dropped = 0;
      for (std::size_t i = 0; i < TestBlock::kCapacity; ++i) {
        TouchingTest test;
        for (std::size_t v = 0; v < 4; ++v)
          for (std::size_t c = 0; c < 2; ++c) {
            test.points[v][c] = random.vector(0, 1) * 0.05 + Vec3(v == 1, v == 2, v == 3) + Vec3(0, 0, v == 0 ? 9 : 0);
            test.points[v][c] *= scale;
          }
        bench.set(i, test);
      }
      for (const auto keep : run(*filter, bench.step(), bench.block(FeatureKind::vf))) dropped += keep == 0;
      EXPECT_EQ(dropped, 64) << name << " scale " << scale;
    }
}

TEST(FilterSimd, AllInstructionSetsAgree) {
  const auto filters = all_filters();
  Random random(7);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (int round = 0; round < 30; ++round) {
        TestBench bench(control_points);
        fill_apart(bench, random, kind, control_points, round * 0.02 - 0.3, 0.2);
        const Step step = bench.step(round % 3 * 0.05, round % 2 ? 1 : 0.7);
        const TestBlock& block = bench.block(kind);
        for (const auto& [name, filter] : filters) {
          const auto expected = run(*filter, step, block);
          for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
            hwy::SetSupportedTargetsForTest(left & -left);
            hwy::GetChosenTarget().Update(hwy::SupportedTargets());
            EXPECT_EQ(run(*filter, step, block), expected) << name << " target " << (left & -left);
            hwy::SetSupportedTargetsForTest(0);
            hwy::GetChosenTarget().Update(hwy::SupportedTargets());
          }
        }
      }
}

TEST(FilterBlock, VerdictsDependOnTheTestAlone) {
  const auto filters = all_filters();
  Random random(10);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (int round = 0; round < 30; ++round) {
        TestBench bench(control_points);
        fill_apart(bench, random, kind, control_points, round * 0.02 - 0.3, 0.2);
        const Step step = bench.step(round % 3 * 0.05, round % 4 == 1 ? 0.7 : 1);
        const TestBlock& block = bench.block(kind);
        std::vector<std::uint8_t> picked(block.size());
        for (auto& pick : picked) pick = random.integer(0, round % 5 + 1) != 0 ? 0 : 1;
        TestBlock some;
        some.append_kept(block, picked);
        if (some.empty()) continue;
        for (const auto& [name, filter] : filters) {
          const auto all = run(*filter, step, block), alone = run(*filter, step, some);
          auto kept = picked;
          test::run_stage(*filter, step, block, kept);
          std::size_t next = 0;
          for (std::size_t i = 0; i < block.size(); ++i) {
            ASSERT_EQ(kept[i], picked[i] & all[i])
                << name << " round " << round << " test " << i << " among others dropped";
            if (picked[i] == 0) continue;
            ASSERT_EQ(alone[next++], all[i]) << name << " round " << round << " test " << i << " among others gathered";
          }
        }
      }
}

TEST(FilterBlock, LeavesOthersAlone) {
  TestBench bench(2);
  Random random(8);
  fill_apart(bench, random, FeatureKind::vf, 2, 1, 0.1);
  const TestBlock& block = bench.block(FeatureKind::vf);
  for (const auto& [name, filter] : all_filters()) {
    std::vector<std::uint8_t> keep(block.padded_size(), 0);
    test::run_stage(*filter, bench.step(), block, keep);
    EXPECT_EQ(keep, std::vector<std::uint8_t>(block.padded_size(), 0)) << name << " brought a test back";
  }
}

}  // namespace
}  // namespace volccd::test
