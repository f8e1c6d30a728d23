// `exact` on cases with known answers, and on small lattices with many degenerate cases, compared with the judge of
// exact_cases.hpp.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "narrowphase/exact/exact_cases.hpp"

namespace volccd::test::exact_decision {
namespace {

struct Known {
  const char* what;
  Case motion;
  TouchCase reason;
  double toi;
  bool degenerate;
};

std::vector<Known> known_vertex_cases() {
  using enum TouchCase;
  return {
      {"through the inside", against_triangle({{.25, .25, 1}, {.25, .25, -1}}), crossing, .5, false},
      {"onto a corner", against_triangle({{0, 0, 1}, {0, 0, -1}}), crossing, .5, false},
      {"past a corner by the least", against_triangle({{-kDenormal, 0, 1}, {0, 0, -1}}), apart, 0, false},
      {"onto a side", against_triangle({{.5, .5, 1}, {.5, .5, -1}}), crossing, .5, false},
      {"past a side", against_triangle({{.5, .5 + kUlp, 1}, {.5, .5 + kUlp, -1}}), apart, 0, false},
      {"touches at the end", against_triangle({{.25, .25, 1}, {.25, .25, 0}}), crossing, 1, false},
      {"nearly touches at the end", against_triangle({{.25, .25, 1}, {.25, .25, kDenormal}}), apart, 0, false},
      {"touches at the start", against_triangle({{.25, .25, 0}, {.25, .25, 1}}), at_start, 0, false},
      {"rests inside", against_triangle({{.25, .25, 0}, {.25, .25, 0}}), at_start, 0, true},
      {"rests beside", against_triangle({{.75, .75, 0}, {.75, .75, 0}}), apart, 0, true},
      {"enters in its plane", against_triangle({{-1, .25, 0}, {1, .25, 0}}), coplanar, .5, true},
      {"along a side's line", against_triangle({{-1, 0, 0}, {1, 0, 0}}), coplanar, .5, true},
      {"curve turns at the plane", against_triangle({{.25, .25, 1}, {.25, .25, -1}, {.25, .25, 1}}), grazing, .5,
       false},
      {"curve turns above", against_triangle({{.25, .25, 1}, {.25, .25, kUlp - 1}, {.25, .25, 1}}), apart, 0, false},
      {"curve turns at a corner in the plane", against_triangle({{-1, -1, 0}, {1, 1, 0}, {-1, -1, 0}}), coplanar, .5,
       true},
      {"curve turns short of a corner", against_triangle({{-1, -1, 0}, {1 - kUlp, 1, 0}, {-1, -1, 0}}), apart, 0, true},
      {"double root",
       {vf,
        {{Vec3(0, 0, 0), Vec3(1, 0, -1), Vec3(1, 1, 0), Vec3(0, 0, 1)},
         {Vec3(0, 0, 0), Vec3(-1, 0, -1), Vec3(1, -1, 0), Vec3(0, 0, 1)}}},
       grazing,
       .5,
       false},
      {"triangle collapses onto the vertex and turns over",
       {vf,
        {{Vec3(0, 0, 0), Vec3(1, 0, 1), Vec3(0, 1, 1), Vec3(-1, -1, 1)},
         {Vec3(0, 0, 0), Vec3(-1, 0, -1), Vec3(0, -1, -1), Vec3(1, 1, -1)}}},
       crossing,
       .5,
       true},
      {"onto a triangle without area",
       {vf,
        {{Vec3(.5, 0, 1), Vec3(-1, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)},
         {Vec3(.5, 0, -1), Vec3(-1, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)}}},
       coplanar,
       .5,
       true},
      {"point meets point",
       {vf,
        {{Vec3(1, 1, 1), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)},
         {Vec3(-3, -3, -3), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)}}},
       coplanar,
       .25,
       true},
      {"point passes point",
       {vf,
        {{Vec3(1, 1, 1), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)},
         {Vec3(-3, -3, -3 + 4 * kUlp), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)}}},
       apart,
       0,
       true},
  };
}

std::vector<Known> known_edge_cases() {
  using enum TouchCase;
  const auto edges = [](Corners a, Corners b) { return Case{ee, {a, b}}; };
  return {
      {"through each other",
       edges({Vec3(-1, 0, 1), Vec3(1, 0, 1), Vec3(0, -1, 0), Vec3(0, 1, 0)},
             {Vec3(-1, 0, -1), Vec3(1, 0, -1), Vec3(0, -1, 0), Vec3(0, 1, 0)}),
       crossing, .5, false},
      {"end on end",
       edges({Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(0, 0, 0), Vec3(0, 1, 0)},
             {Vec3(0, 0, -1), Vec3(1, 0, -1), Vec3(0, 0, 0), Vec3(0, 1, 0)}),
       crossing, .5, false},
      {"end past end",
       edges({Vec3(kDenormal, 0, 1), Vec3(1, -1, 1), Vec3(0, 0, 0), Vec3(0, 1, 0)},
             {Vec3(kDenormal, 0, -1), Vec3(1, -1, -1), Vec3(0, 0, 0), Vec3(0, 1, 0)}),
       apart, 0, false},
      {"slide along one line",
       edges({Vec3(-3, 0, 0), Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)},
             {Vec3(1, 0, 0), Vec3(3, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}),
       coplanar, .5, true},
      {"parallel, onto each other",
       edges({Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(.5, 0, 0), Vec3(2, 0, 0)},
             {Vec3(0, -1, 0), Vec3(1, -1, 0), Vec3(.5, 0, 0), Vec3(2, 0, 0)}),
       coplanar, .5, true},
      {"parallel, past each other",
       edges({Vec3(-1, 1, 0), Vec3(0, 2, 0), Vec3(1, 1, 0), Vec3(2, 2, 0)},
             {Vec3(9, 8, 0), Vec3(10, 9, 0), Vec3(1, 1, 0), Vec3(2, 2, 0)}),
       apart, 0, true},
      {"meet in a plane",
       edges({Vec3(-3, 0, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)},
             {Vec3(-2, 0, 0), Vec3(3, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)}),
       coplanar, .25, true},
      {"cross at rest",
       edges({Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)},
             {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)}),
       at_start, 0, true},
      {"point meets edge",
       edges({Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(1, 0, 0)},
             {Vec3(0, 0, -3), Vec3(0, 0, -3), Vec3(-1, 0, 0), Vec3(1, 0, 0)}),
       coplanar, .25, true},
  };
}

TEST(ExactDecision, KnownAnswers) {
  std::vector<Known> cases = known_vertex_cases();
  for (const Known& known : known_edge_cases()) cases.push_back(known);
  for (const Known& known : cases) {
    const ExactAnswer answer = known.motion.answer();
    EXPECT_EQ(answer.touches, known.reason != TouchCase::apart) << known.what;
    EXPECT_EQ(answer.reason, known.reason) << known.what;
    EXPECT_EQ(answer.toi, known.toi) << known.what;
    EXPECT_EQ(answer.toi_exact, answer.touches) << known.what;
    EXPECT_EQ(answer.degenerate, known.degenerate) << known.what;
    EXPECT_EQ(answer.side != 0, answer.touches && !(answer.degenerate && answer.reason != TouchCase::crossing))
        << known.what;
  }
}

TEST(ExactDecision, TimesBetweenDoubles) {
  // 1 - 3 t = 0, and 1 - 2 t^2 = 0. fma rounds once, and therefore has the right sign.
  const double third = against_triangle({{.25, .25, 1}, {.25, .25, -2}}).answer().toi;
  EXPECT_LT(std::fma(3, third, -1), 0);
  EXPECT_GT(std::fma(3, std::nextafter(third, 1), -1), 0);
  const Case root = against_triangle({{.25, .25, 1}, {.25, .25, 1}, {.25, .25, -1}});
  const ExactAnswer answer = root.answer();
  EXPECT_FALSE(answer.toi_exact);
  EXPECT_LT(std::fma(answer.toi, answer.toi, -.5), 0);
  EXPECT_GT(std::fma(std::nextafter(answer.toi, 1), std::nextafter(answer.toi, 1), -.5), 0);
  // At t = 1/3 the vertex is on a side of the triangle, or beside it by about 1e-15.
  const auto at_side = [](double e) { return against_triangle({{.5, 1 + e, 1}, {.5, -.5 + e, -2}}).answer().touches; };
  EXPECT_TRUE(at_side(0));
  EXPECT_TRUE(at_side(-0x1p-50));
  EXPECT_FALSE(at_side(0x1p-50));
  // The vertex is below the plane afterwards.
  EXPECT_EQ(answer.side, -root.with([](Corners& x) { x[0].z() *= -1; }).answer().side);
}

TEST(ExactDecision, AgreesWithAdvancement) {
  std::array<int, 5> seen{};
  int degenerate = 0;
  for_lattice_cases(1, [&](const Case& c, Random&) {
    const ExactAnswer answer = c.answer();
    ++seen[static_cast<std::size_t>(answer.reason)];
    degenerate += answer.degenerate;
    const Real judge = advance(c);
    ASSERT_EQ(answer.touches, judge <= 1) << static_cast<double>(judge);
    if (!answer.touches) return;
    // The distance of curves may decrease with the fourth power of time.
    ASSERT_NEAR(answer.toi, static_cast<double>(judge), 1.5e-2);
    ASSERT_EQ(c.compare(answer.toi, 0), answer.toi_exact ? 0 : 1);
    ASSERT_LT(c.distance(answer.toi), 1e-14L);
    for (double t = 0; t < answer.toi; t += 1 / 64.0) ASSERT_EQ(c.compare(t, 0), 1) << t;
  });
  for (const int n : seen) EXPECT_GE(n, 3);
  EXPECT_GT(degenerate, 50);
}

void expect_same(const ExactAnswer& a, const ExactAnswer& b, const char* what) {
  ASSERT_EQ(a.touches, b.touches) << what;
  ASSERT_EQ(a.toi, b.toi) << what;
  ASSERT_EQ(a.toi_exact, b.toi_exact) << what;
  ASSERT_EQ(a.reason, b.reason) << what;
  ASSERT_EQ(std::abs(a.side), std::abs(b.side)) << what;
}

TEST(ExactDecision, Symmetries) {
  for_lattice_cases(2, [](const Case& c, Random& random) {
    const ExactAnswer answer = c.answer();
    const bool is_vf = c.kind == vf;
    expect_same(answer, c.with([&](Corners& x) { std::swap(x[is_vf ? 1 : 0], x[is_vf ? 2 : 1]); }).answer(), "corners");
    expect_same(answer, c.with([](Corners& x) { std::swap(x[2], x[3]); }).answer(), "last two");
    if (!is_vf) {
      const auto swap_edges = [](Corners& x) { x = {x[2], x[3], x[0], x[1]}; };
      expect_same(answer, c.with(swap_edges).answer(), "edges");
    }
    const auto every = [&](auto change) {
      return c
          .with([&](Corners& x) {
            for (Vec3& p : x) p = change(p);
          })
          .answer();
    };
    expect_same(answer, every([](const Vec3& p) { return Vec3(p.y(), p.z(), p.x()); }), "axes");
    expect_same(answer, every([](const Vec3& p) { return Vec3(p.x() + 2 * p.z(), p.y() - p.x(), p.z()); }), "sheared");
    expect_same(answer, every([](const Vec3& p) { return Vec3(p * 0x1p-1074); }), "denormals");
    expect_same(answer, every([](const Vec3& p) { return Vec3(p * 0x1p1020); }), "huge");
    expect_same(answer, every([](const Vec3& p) { return Vec3(p * 0x1p-498); }), "about 1e-150");
    expect_same(answer, every([](const Vec3& p) { return Vec3(p.array() + 1e8); }), "far from the origin");
    const Vec3 drift(static_cast<double>(random.below(9)), -3, 1);
    Case moved = c;
    for (std::size_t k = 0; k < moved.control.size(); ++k)
      for (Vec3& p : moved.control[k]) p += static_cast<double>(k) * drift;
    expect_same(answer, moved.answer(), "common velocity");
    Case back = c;
    std::reverse(back.control.begin(), back.control.end());
    ASSERT_EQ(answer.touches, back.answer().touches) << "backwards";
  });
}

TEST(ExactDecision, TimeLimit) {
  int tried = 0;
  for_lattice_cases(3, [&](const Case& c, Random&) {
    const ExactAnswer answer = c.answer();
    if (!answer.touches || answer.toi == 0 || answer.toi == 1) return;
    ++tried;
    const double before = std::nextafter(answer.toi, 0), after = std::nextafter(answer.toi, 1);
    EXPECT_FALSE(c.answer(before).touches);
    EXPECT_EQ(c.answer(answer.toi).touches, answer.toi_exact);
    expect_same(answer, c.answer(after), "after");
  });
  EXPECT_GT(tried, 50);
}

/// Motions whose contact is exactly at t = p / q.
std::vector<Case> contacts_at(double p, double q) {
  const double n = q - p;
  const auto edges = [&](Corners a, Corners b) { return Case{ee, {a, b}}; };
  return {
      against_triangle({{.25, .25, p}, {.25, .25, -n}}),
      against_triangle({{.25, .25, p * p}, {.25, .25, -p * n}, {.25, .25, n * n}}),  // it grazes, with z = (q t - p)^2
      against_triangle({{.25, -p, 0}, {.25, n, 0}}),                                 // in the plane
      edges({Vec3(-1, 0, p), Vec3(1, 0, p), Vec3(0, -1, 0), Vec3(0, 1, 0)},
            {Vec3(-1, 0, -n), Vec3(1, 0, -n), Vec3(0, -1, 0), Vec3(0, 1, 0)}),
      edges({Vec3(-p - 1, 0, 0), Vec3(-p, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)},  // in the plane
            {Vec3(n - 1, 0, 0), Vec3(n, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)}),
      edges({Vec3(-p - 1, 0, 0), Vec3(-p, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)},  // along one line
            {Vec3(n - 1, 0, 0), Vec3(n, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)}),
  };
}

// No double is the time of contact. The doubles next to it differ in whether the contact is in the step.
TEST(ExactDecision, TimeLimitBesideTimesThatAreNoDoubles) {
  for (const double q : {3., 5., 7., 9., 11., 1001., 65537.})
    for (double p = 1; p < q; p += 1 + std::floor(q / 12)) {
      if (std::gcd(static_cast<int>(p), static_cast<int>(q)) != 1) continue;
      double before = p / q;
      if (std::fma(q, before, -p) > 0) before = std::nextafter(before, 0);
      const double after = std::nextafter(before, 1);
      ASSERT_LT(std::fma(q, before, -p), 0);
      ASSERT_GT(std::fma(q, after, -p), 0);
      const std::vector<Case> cases = contacts_at(p, q);
      for (std::size_t i = 0; i < cases.size(); ++i) {
        SCOPED_TRACE(testing::Message() << p << " / " << q << ", case " << i);
        EXPECT_FALSE(cases[i].answer(before).touches);
        for (const double t_max : {after, 1.0}) {
          const ExactAnswer answer = cases[i].answer(t_max);
          EXPECT_TRUE(answer.touches);
          EXPECT_EQ(answer.toi, before);
          EXPECT_FALSE(answer.toi_exact);
        }
      }
    }
}

// A vertex passes a corner of a triangle in their plane: it meets one side at 1/4, and the other one so soon afterwards
// that the same double is before both.
TEST(ExactDecision, TheEarlierOfTwoTimesBeforeOneDouble) {
  constexpr double kTiny = 0x1p-58;
  for (const bool mirrored : {false, true}) {
    std::array<std::size_t, 3> order{0, 1, 2};
    do {
      Case c{vf, {}};
      for (const double y : {-.25, .75}) {
        const Vec3 corners[3] = {{-1, 0, 0}, {0, 0, 0}, {-1, 1, 0}};
        Corners x{Vec3(-kTiny, y, 0), corners[order[0]], corners[order[1]], corners[order[2]]};
        if (mirrored)
          for (Vec3& p : x) std::swap(p.x(), p.y());
        c.control.push_back(x);
      }
      const ExactAnswer answer = c.answer();
      EXPECT_TRUE(answer.touches && answer.toi_exact);
      EXPECT_EQ(answer.toi, .25);
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

// The points are coplanar at two times, of which one is a double and the end of the interval in which the other one is
// searched for. The features touch at the other one only.
TEST(ExactDecision, TimesNextToOtherRoots) {
  // z = (1 - t) (2 - 3 t), x = 3 - 4 t: touches at 2/3, is beside the triangle at 1.
  const ExactAnswer inner = against_triangle({{3, .25, 2}, {1, .25, -.5}, {-1, .25, 0}}).answer();
  EXPECT_TRUE(inner.touches);
  EXPECT_FALSE(inner.toi_exact);
  EXPECT_EQ(inner.toi, 2. / 3);
  // z = (t - 1/2) (n (t - 1/2) - e), x = t - 1/2 - e / 4. The time 1/2 + e / n is a fraction of a power of two or
  // not, but no double.
  constexpr double e = 0x1p-54;
  for (const double n : {1, 3}) {
    Case near{vf, {}};
    for (int c = 0; c < 3; ++c) {
      const double z = (c - 1) * e / 2, x = e / 4;
      near.control.push_back(
          {Vec3(.5 * (c - 1), 0, n * (c == 1 ? -.25 : .25)), Vec3(x, -1, z), Vec3(x, 1, z), Vec3(1, 0, z)});
    }
    const ExactAnswer next = near.answer();
    EXPECT_TRUE(next.touches);
    EXPECT_FALSE(next.toi_exact);
    EXPECT_EQ(next.toi, .5);
    EXPECT_FALSE(near.answer(.5).touches);
  }
}

TEST(ExactDecision, LinesAsCurves) {
  for_lattice_cases(4, [](const Case& c, Random&) {
    if (c.control.size() != 2) return;
    Case curve = c;
    curve.control.insert(curve.control.begin() + 1, c.control[0]);
    for (std::size_t i = 0; i < 4; ++i) curve.control[1][i] = (c.control[0][i] + c.control[1][i]) / 2;
    expect_same(c.answer(), curve.answer(), "three control points");
  });
}

}  // namespace
}  // namespace volccd::test::exact_decision
