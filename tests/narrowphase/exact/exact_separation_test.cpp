// `exact` with a separation: when features come within it.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "narrowphase/exact/exact_cases.hpp"

namespace volccd::test::exact_decision {
namespace {

TEST(ExactSeparation, KnownTimesOfApproach) {
  const auto edges = [](Corners a, Corners b) { return Case{ee, {a, b}}; };
  const Case onto_inside = against_triangle({{.25, .25, 2}, {.25, .25, -2}});
  const Case onto_side = against_triangle({{.5, -2, 0}, {.5, 2, 0}}),
             onto_corner = against_triangle({{-2, 0, 0}, {2, 0, 0}});
  const Case past_corner = against_triangle({{-4, -3, 0}, {4, -3, 0}});
  const Case beside = against_triangle({{-2, .25, 1}, {2, .25, 1}});  // at the distance of the plane at all times
  const Case along = against_triangle({{-2, -1, 0}, {2, -1, 0}});     // at the distance of a side's line at all times
  const Case turns = against_triangle({{.25, .25, 3}, {.25, .25, -1}, {.25, .25, 3}});
  const Case crossing = edges({Vec3(-1, 0, 2), Vec3(1, 0, 2), Vec3(0, -1, 0), Vec3(0, 1, 0)},
                              {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)});
  const Case parallel = edges({Vec3(-1, 0, 2), Vec3(1, 0, 2), Vec3(-1, 0, 0), Vec3(1, 0, 0)},
                              {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(1, 0, 0)});
  const struct {
    const char* what;
    const Case& motion;
    double separation, toi;  // toi < 0: apart
    TouchCase reason;
  } cases[] = {
      {"inside", onto_inside, 1, .25, TouchCase::approach},
      {"at the start", onto_inside, 2, 0, TouchCase::at_start},
      {"a side", onto_side, 1, .25, TouchCase::approach},
      {"a corner", onto_corner, 1, .25, TouchCase::approach},
      {"past a corner", past_corner, 3, .5, TouchCase::approach},
      {"not quite past a corner", past_corner, std::nextafter(3.0, 0), -1, TouchCase::apart},
      {"beside, until above a side", beside, 1, .5, TouchCase::approach},
      {"too high beside", beside, std::nextafter(1.0, 0), -1, TouchCase::apart},
      {"along a line, until beside its edge", along, 1, .5, TouchCase::approach},
      {"turns at the separation", turns, 1, .5, TouchCase::approach},
      {"turns before the separation", turns, std::nextafter(1.0, 0), -1, TouchCase::apart},
      {"edges", crossing, .5, .75, TouchCase::approach},
      {"parallel edges", parallel, .5, .75, TouchCase::approach},
      {"a denormal separation", onto_inside, kDenormal, std::nextafter(.5, 0), TouchCase::approach},
  };
  for (const auto& known : cases) {
    const ExactAnswer answer = known.motion.answer(1, known.separation);
    EXPECT_EQ(answer.touches, known.toi >= 0) << known.what;
    EXPECT_EQ(answer.toi, std::max(known.toi, 0.0)) << known.what;
    EXPECT_EQ(answer.reason, known.reason) << known.what;
    EXPECT_EQ(answer.toi_exact, answer.touches && known.separation != kDenormal) << known.what;
  }
}

TEST(ExactSeparation, AgreesWithAdvancement) {
  int touching = 0, apart = 0;
  for_lattice_cases(6, [&](const Case& c, Random& random) {
    const double separation = 0.25 * (1 + static_cast<double>(random.below(8)));
    const ExactAnswer answer = c.answer(1, separation);
    const Real judge = advance(c, separation);
    // Features may pass at the separation itself.
    ASSERT_TRUE(judge <= 1 || !answer.touches) << static_cast<double>(judge);
    ASSERT_TRUE(judge > 1 || answer.touches || c.compare(static_cast<double>(judge), separation) > 0);
    ++(answer.touches ? touching : apart);
    const double until = answer.touches ? answer.toi : 1;
    for (double t = 0; t < until; t += 1 / 64.0) ASSERT_EQ(c.compare(t, separation), 1) << t;
    if (!answer.touches) return;
    ASSERT_NEAR(answer.toi, static_cast<double>(judge), 1.5e-2);
    ASSERT_EQ(c.compare(answer.toi, separation) <= 0, answer.toi_exact);
    ASSERT_LE(std::abs(c.distance(answer.toi) - separation),
              answer.reason == TouchCase::at_start ? separation : 1e-14L);
    ASSERT_EQ(c.answer(answer.toi, separation).touches, answer.toi_exact);
  });
  EXPECT_GT(touching, 200);
  EXPECT_GT(apart, 50);
}

TEST(ExactSeparation, ComparesDistances) {
  // 3-4-5 triangles at time 3/4: the length is exactly 5 at every scale.
  for (const double scale : {1.0, 0x1p-1070, 0x1p1000}) {
    const Case c = against_triangle({{-scale * 6, -scale * 4, 0}, {-scale * 2, -scale * 4, 0}});
    EXPECT_EQ(c.compare(.75, 5 * scale), 0);
    EXPECT_EQ(c.compare(.75, std::nextafter(5 * scale, 0)), 1);
    EXPECT_EQ(c.compare(.75, std::nextafter(5 * scale, 9 * scale)), -1);
  }
  Random random(5);
  for (int i = 0; i < 3000; ++i) {
    Case c{i % 2 ? vf : ee, std::vector<Corners>(2 + static_cast<std::size_t>(i / 2 % 2))};
    for (Corners& x : c.control)
      for (Vec3& p : x) p = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), i % 3 ? random.uniform(-.1, .1) : 0);
    const double t = random.uniform();
    const auto d = static_cast<double>(c.distance(t));
    if (d < 1e-9) continue;
    ASSERT_EQ(c.compare(t, d * (1 + 1e-12)), -1);
    ASSERT_EQ(c.compare(t, d * (1 - 1e-12)), 1);
  }
}

}  // namespace
}  // namespace volccd::test::exact_decision
