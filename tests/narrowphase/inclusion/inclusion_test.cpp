// `inclusion` on cases with simple answers, and its rounding bounds compared with rational arithmetic. truth_test.cpp
// has published ground truth, and tests/oracle/judge random near-degenerate tests.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <boost/multiprecision/gmp.hpp>

#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/detail/motion_piece.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

using Rational = boost::multiprecision::mpq_rational;

const std::array<Vec3, 3> kTriangle = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};

/// A vertex on a Bezier curve, and kTriangle at rest.
std::vector<Contact> against_triangle(const std::vector<Vec3>& curve, double separation = 0, double t_max = 1) {
  std::vector<Vec3> points;
  for (const Vec3& p : curve) points.insert(points.end(), {p, kTriangle[0], kTriangle[1], kTriangle[2]});
  const volccd::QuerySet set(FeatureKind::vf, static_cast<int>(curve.size()), points);
  std::vector<Contact> contacts;
  NarrowCounters counters;
  test::run_stage(Inclusion(), set.step(t_max, separation), FeatureKind::vf, set.pairs(), contacts, counters);
  return contacts;
}

void expect_time(const std::vector<Contact>& contacts, double toi) {
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LE(contacts[0].toi, toi);
  EXPECT_GT(contacts[0].toi, toi - 1e-9);
}

TEST(Inclusion, StraightThroughATriangle) {
  const auto contacts = against_triangle({{0.25, 0.25, 1}, {0.25, 0.25, -2}});
  expect_time(contacts, 1.0 / 3);
  EXPECT_LT((contacts[0].normal - Vec3(0, 0, 1)).norm(), 1e-9);
  EXPECT_LT((contacts[0].point - Vec3(0.25, 0.25, 0)).norm(), 1e-8);
  EXPECT_FALSE(contacts[0].at_start);
  EXPECT_TRUE(against_triangle({{0.75, 0.75, 1}, {0.75, 0.75, -2}}).empty());
}

TEST(Inclusion, AccelerationTurnsBackAtTheTriangle) {
  // z(t) = (1 - 2t)^2 + lift: with lift = 0 it touches at t = 1/2 only, and with lift < 0 first at (1 - sqrt(-lift)) /
  // 2.
  const auto curve = [](double lift) {
    return std::vector<Vec3>{{0.25, 0.25, 1 + lift}, {0.25, 0.25, -1 + lift}, {0.25, 0.25, 1 + lift}};
  };
  EXPECT_TRUE(against_triangle(curve(1e-12)).empty());
  expect_time(against_triangle(curve(-0.0625)), 0.375);
  const auto grazing = against_triangle(curve(0));  // double roots look like near misses and stay undecided
  ASSERT_EQ(grazing.size(), 1u);
  EXPECT_LE(grazing[0].toi, 0.5);
  EXPECT_GT(grazing[0].toi, 0.5 - 1e-6);
}

TEST(Inclusion, SeparationMovesTheContactForward) {
  // Above the inside, the distance is z; beside an edge and beyond a corner, it is that to the edge or corner.
  expect_time(against_triangle({{0.25, 0.25, 2}, {0.25, 0.25, 0}}, 0.5), 0.75);
  expect_time(against_triangle({{0.5, -3, 0}, {0.5, 1, 0}}, 0.5), 0.625);
  expect_time(against_triangle({{-3, -4, 0}, {0, 0, 0}}, 0.5), 0.9);
  EXPECT_TRUE(against_triangle({{0.25, 0.25, 2}, {0.25, 0.25, 0.5 + 1e-12}}, 0.5).empty());
  const auto contacts = against_triangle({{-3, -4, 0}, {0, 0, 0}}, 0.5);
  EXPECT_LT((contacts[0].normal - Vec3(-0.6, -0.8, 0)).norm(), 1e-6);
  // On a curve, z = 2 (1 - t)^2 reaches 0.5 at t = 1/2.
  expect_time(against_triangle({{0.25, 0.25, 2}, {0.25, 0.25, 0}, {0.25, 0.25, 0}}, 0.5), 0.5);
}

TEST(Inclusion, CloserThanTheSeparationAtTheStartIsFlagged) {
  for (const double z : {0.0, 0.25, 0.4999}) {
    const auto contacts = against_triangle({{0.25, 0.25, z}, {0.25, 0.25, 3}}, 0.5);
    ASSERT_EQ(contacts.size(), 1u) << z;
    EXPECT_EQ(contacts[0].toi, 0);
    EXPECT_TRUE(contacts[0].at_start);
  }
  EXPECT_TRUE(against_triangle({{0.25, 0.25, 0}, {0.25, 0.25, 1}}).at(0).at_start);
  EXPECT_FALSE(against_triangle({{0.25, 0.25, 0.75}, {0.25, 0.25, 0}}, 0.5).at(0).at_start);
  // Exactly as far apart as the separation, and one rounding further.
  EXPECT_TRUE(against_triangle({{0.25, 0.25, 0.5}, {0.25, 0.25, 0}}, 0.5).at(0).at_start);
  EXPECT_FALSE(against_triangle({{0.25, 0.25, std::nextafter(0.5, 1.0)}, {0.25, 0.25, 0}}, 0.5).at(0).at_start);
}

TEST(Inclusion, PartsLeaveNoGap) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(0, 1);
  int rounded_down = 0, beyond_from = 0;
  for (int i = 0; i < 20000; ++i) {
    double lo = number(random), hi = i % 2 ? number(random) : lo + std::ldexp(number(random), -int(random() % 40));
    if (lo > hi) std::swap(lo, hi);
    hi = std::min(hi, 1.0);
    rounded_down += lo + (hi - lo) < hi ? 1 : 0;
    const detail::Split whole(lo, hi, 0, 1);
    ASSERT_EQ(whole.from, lo);
    ASSERT_EQ(whole.to, hi);
    const double begin = 0.5 * number(random), end = begin + 0.5 * number(random);
    const detail::Split split(lo, hi, begin, end);
    const Rational width = Rational(hi) - Rational(lo);
    ASSERT_GE(Rational(split.before) * width, Rational(split.from) - Rational(lo));
    ASSERT_LE(Rational(split.after) * width, Rational(split.to) - Rational(lo));
    // The difference is small, because an outer part that extends far into the inner one is seldom free of roots.
    ASSERT_LE(split.before, begin + 0x1p-49 / (hi - lo));
    beyond_from += Rational(begin) * width < Rational(split.from) - Rational(lo) ? 1 : 0;
  }
  EXPECT_GT(rounded_down, 0);  // otherwise the test proves nothing
  EXPECT_GT(beyond_from, 1000);
}

TEST(Inclusion, ExactIsNotAskedWhereItWouldTakeLong) {
  // The vertex moves down to a triangle that is lower by 2^-`power`, and up again. They do not touch, but doubles
  // cannot show this.
  const auto ask = [](int power, int exact_bits) {
    std::vector<Vec3> points;
    for (const double z : {1.0, -1.0, 1.0}) {
      points.emplace_back(0.25, 0.25, z);
      for (Vec3 corner : kTriangle) points.push_back(corner - Vec3(0, 0, std::ldexp(1.0, -power)));
    }
    const volccd::QuerySet set(FeatureKind::vf, 3, points);
    std::vector<Contact> contacts;
    NarrowCounters counters;
    test::run_stage(Inclusion({.exact_bits = exact_bits}), set.step(1), FeatureKind::vf, set.pairs(), contacts,
                    counters);
    EXPECT_EQ(counters.undecided, 1u);
    return contacts.size();
  };
  const int standard = Inclusion::Config{}.exact_bits;
  EXPECT_EQ(ask(standard - 1, standard), 0u);
  EXPECT_EQ(ask(standard, standard), 1u);  // with one more bit it stays undecided, and is reported
  EXPECT_EQ(ask(standard, standard + 1), 0u);
}

TEST(Inclusion, CoordinateBitsSpanAllCoordinates) {
  std::array<double, 24> x{};
  const TestMotion motion{FeatureKind::vf, 2, {&x[0], &x[6], &x[12], &x[18]}};
  EXPECT_EQ(coordinate_bits(motion), 0);
  x[3] = -6;  // binary 110
  EXPECT_EQ(coordinate_bits(motion), 2);
  x[23] = 0x1.8p-10;
  EXPECT_EQ(coordinate_bits(motion), 3 + 11);
  x[0] = std::numeric_limits<double>::max();
  x[1] = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(coordinate_bits(motion), 2098);
}

/// A degenerate triangle (parallel edges) far from the origin, whose corners are not exactly on one line because of
/// rounding. The other feature is near it at the end of the step.
std::vector<Vec3> near_a_sliver(std::mt19937_64& random, FeatureKind kind, int control_points) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  const Vec3 offset = std::ldexp(1.0, static_cast<int>(random() % 20)) * vector(), side = vector();
  const double share = 0.75 + 0.25 * number(random), near = std::ldexp(1.0, -30 - static_cast<int>(random() % 24));
  const bool turns = random() % 2 == 0, comes = random() % 2 == 0;
  std::vector<Vec3> points;
  for (int c = 0; c < control_points; ++c) {
    const Vec3 a = offset + vector(), e = turns ? vector() : side;
    const Vec3 other = a + number(random) * e + near * vector() + (comes && c == 0 ? 0.25 : 0.0) * vector();
    const std::vector<Vec3> now = kind == FeatureKind::vf ? std::vector<Vec3>{other, a, a + e, a + share * e}
                                                          : std::vector<Vec3>{a, a + e, other, other + share * e};
    points.insert(points.end(), now.begin(), now.end());
  }
  return points;
}

TEST(Inclusion, UndecidedTestsComeAsNearAsPromised) {
  std::mt19937_64 random(21);
  std::size_t undecided = 0;
  for (int i = 0; i < 20000; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    const int control_points = i % 4 < 2 ? 2 : 3;
    const std::vector<Vec3> points = near_a_sliver(random, kind, control_points);
    const volccd::QuerySet set(kind, control_points, points);
    std::vector<Contact> contacts;
    NarrowCounters counters;
    test::run_stage(Inclusion(), set.step(1), kind, set.pairs(), contacts, counters);
    if (contacts.empty() || counters.undecided == 0) continue;
    TestMotion motion{kind, control_points, {}};
    for (Index v = 0; v < 4; ++v) motion.points[v] = set.step(1).motion.at(v);
    if (exact_first_touch(motion).touches) continue;
    ++undecided;
    double size = 0;
    for (std::size_t p = 0; p < points.size(); ++p)
      size = std::max(size, (points[p] - points[p / 4 * 4]).cwiseAbs().maxCoeff());
    // Whether the features touch at some time from the reported one to at most the tolerance later.
    bool near = false;
    for (int k = 0; k <= 8 && !near; ++k)
      near = compare_distance(motion, std::min(1.0, contacts[0].toi + k * 1.25e-10), kUndecidedDistance * size) <= 0;
    ASSERT_TRUE(near) << "test " << i << " at " << contacts[0].toi;
  }
  EXPECT_GT(undecided, 500u);
}

/// All points are in a plane of constant x, y or z, so that the polynomial is zero.
std::vector<Vec3> in_a_plane(std::mt19937_64& random, FeatureKind kind, int control_points, int axis, bool on_a_grid) {
  std::uniform_real_distribution<double> number(-1, 1);
  const double height = on_a_grid ? 0 : 100 * number(random);
  // The features begin on different sides of a gap, because otherwise they would rarely be apart at t = 0.
  const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
  std::vector<Vec3> points;
  for (int c = 0; c < control_points; ++c)
    for (std::size_t i = 0; i < 4; ++i) {
      Vec3 p(number(random), number(random), number(random));
      if (c == 0) p[(axis + 1) % 3] += i < second ? 1.125 : -1.125;
      if (on_a_grid) p = (2 * p).array().round();
      p[axis] = height;
      points.push_back(p);
    }
  return points;
}

TEST(Inclusion, TestsInAPlaneAreDecided) {
  std::mt19937_64 random(7);
  std::size_t contacts_found = 0, undecided = 0;
  for (int i = 0; i < 12000; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    const int control_points = i % 4 < 2 ? 2 : 3;
    const bool on_a_grid = i % 10 == 0;  // vertices meet vertices here
    const std::vector<Vec3> points = in_a_plane(random, kind, control_points, i % 3, on_a_grid);
    const volccd::QuerySet set(kind, control_points, points);
    std::vector<Contact> contacts;
    NarrowCounters counters;
    test::run_stage(Inclusion(), set.step(1), kind, set.pairs(), contacts, counters);
    TestMotion motion{kind, control_points, {}};
    for (Index v = 0; v < 4; ++v) motion.points[v] = set.step(1).motion.at(v);
    const ExactAnswer exact = exact_first_touch(motion);
    ASSERT_TRUE(exact.touches ? contacts.size() == 1 : contacts.empty() || counters.undecided == 1) << "test " << i;
    if (!on_a_grid) undecided += counters.undecided;
    if (!exact.touches) continue;
    ++contacts_found;
    ASSERT_LE(contacts[0].toi, exact.toi) << "test " << i;
    ASSERT_GE(contacts[0].toi, exact.toi - 1e-9) << "test " << i;
    ASSERT_EQ(contacts[0].at_start, exact.reason == TouchCase::at_start) << "test " << i;
  }
  EXPECT_GT(contacts_found, 5000u);
  EXPECT_LT(undecided, 5u);
}

/// A fall onto the triangle, a slide within its plane, and a double root use all ways to an answer.
TEST(Inclusion, TheAnswerDependsNeitherOnTheBatchNorOnTheEnd) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::vector<Query> queries(1000);
    for (std::size_t i = 0; i < queries.size(); ++i)
      for (Vec3& p : queries[i]) {
        p = {number(random), number(random), number(random)};
        if (i % 3 == 0) p = (2 * p).array().round();
      }
    const QuerySet all(kind, queries);
    const std::vector<Contact> contacts = all.test(Inclusion());
    ASSERT_GT(contacts.size(), 100u);
    for (const Contact& contact : contacts) {
      const auto one = all.pairs().subspan(all.query_of(contact), 1);
      const auto alone = [&](double t_max) {
        std::vector<Contact> found;
        NarrowCounters counters;
        test::run_stage(Inclusion(), all.step(t_max), kind, one, found, counters);
        return found;
      };
      ASSERT_EQ(alone(contact.toi), std::vector<Contact>{contact});
      if (contact.toi > 0) {
        ASSERT_TRUE(alone(std::nextafter(contact.toi, 0)).empty());
      }
    }
  }
}

/// det(p1 - p0, p2 - p0, p3 - p0) at t, exactly.
template <int kPoints>
Rational coplanarity(const std::array<std::array<Vec3, kPoints>, 4>& curves, const Rational& t) {
  const Rational s = 1 - t;
  std::array<std::array<Rational, 3>, 4> p;
  for (std::size_t i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t c) { return Rational(curves[i][c][k]); };
      p[i][static_cast<std::size_t>(k)] = kPoints == 2
                                              ? Rational(s * at(0) + t * at(1))
                                              : Rational(s * s * at(0) + 2 * s * t * at(1) + t * t * at(kPoints - 1));
    }
  std::array<std::array<Rational, 3>, 3> e;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) e[i][k] = p[i + 1][k] - p[0][k];
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/// Compares the polynomial of the piece, evaluated exactly from its computed coefficients, with the true polynomial.
template <int kPoints>
void expect_bounds_hold(std::uint64_t seed, double* closest) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> number(-1, 1), part(0, 1);
  std::array<std::array<Vec3, kPoints>, 4> curves;
  const Vec3 offset =
      seed % 2 == 0 ? Vec3(Vec3::Zero()) : Vec3(1e3 * Vec3(number(random), number(random), number(random)));
  for (auto& curve : curves)
    for (Vec3& p : curve)
      p = offset + Vec3(number(random), number(random), std::ldexp(number(random), -int(seed % 7) * 4));
  detail::TestPoints x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = curves[i][0].data();
  double lo = part(random), hi = part(random);
  if (lo > hi) std::swap(lo, hi);
  if (seed % 3 == 0) hi = std::min(1.0, lo + std::ldexp(1.0, -int(seed % 40)));
  const detail::BoundedTest<kPoints> test(FeatureKind::vf, x, 0);
  detail::MotionPiece<kPoints> piece(test, lo, hi);
  piece.prove_never_coplanar();
  constexpr int degree = detail::MotionPiece<kPoints>::kDegree;
  Rational bound = 0;
  for (int k = 0; k <= degree; ++k) bound = std::max<Rational>(bound, Rational(piece.error(k)));
  for (int i = 0; i <= degree; ++i) {
    const Rational s = Rational(i) / degree, r = 1 - s;
    Rational value = 0, error = 0;
    for (int k = 0; k <= degree; ++k) {
      Rational weight = 1;
      for (int j = 0; j < degree; ++j) weight *= j < k ? s : r;
      value += Rational(piece.coefficients()[static_cast<std::size_t>(k)]) * weight;
      error += Rational(piece.error(k)) * weight;
    }
    const Rational t = Rational(lo) + s * (Rational(hi) - Rational(lo));
    const Rational off = abs(value - coplanarity<kPoints>(curves, t));
    ASSERT_LE(off, error) << seed;
    *closest = std::max(*closest, Rational(off / error).template convert_to<double>());
  }
}

/// The bounds are not much too large: some errors come within a tenth of them.
TEST(InclusionBounds, HoldForTheCoplanarityPolynomialOfAnyPart) {
  double closest2 = 0, closest3 = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) expect_bounds_hold<2>(seed, &closest2);
  for (std::uint64_t seed = 0; seed < 1000; ++seed) expect_bounds_hold<3>(seed, &closest3);
  EXPECT_GT(closest2, 0.03);
  EXPECT_GT(closest3, 0.01);
}

}  // namespace
}  // namespace volccd::test
