// The vector kernel of `inclusion` for tests with a separation, against exact distances and against the search, which
// decides one test at a time.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/narrowphase/detail/clearly_separated.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>

#include "narrowphase/query_set.hpp"
#include "support/one_test.hpp"
#include "support/run_seeds.hpp"

namespace volccd::test::clearly_separated {
namespace {

using cases::Case;
using cases::Choices;

/// Four points at each control point.
using Points = std::vector<Vec3>;
using Flags = std::vector<std::uint8_t>;

struct Number {
  std::mt19937_64& random;

  double operator()() { return std::uniform_real_distribution<double>(-1, 1)(random); }
  int below(int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); }
  Vec3 vector() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }
  /// Of integers that are multiples of 16.
  Vec3 integers(double size) { return 16 * (size / 16 * vector()).array().round(); }
};

Flags flags_of(const QuerySet& set, double separation) {
  const Step step = set.step(1, separation);
  Flags all;
  TestBlock block;
  for (std::size_t i = 0; i < set.size(); i += block.size()) {
    block.gather(step, set.kind(), set.pairs().subspan(i, std::min(TestBlock::kCapacity, set.size() - i)));
    std::array<std::uint8_t, TestBlock::kCapacity> keep;
    keep.fill(1);
    detail::drop_clearly_separated(block, separation, keep);
    all.insert(all.end(), keep.begin(), keep.begin() + static_cast<std::ptrdiff_t>(block.size()));
  }
  return all;
}

TestMotion motion_of(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices) {
  return {kind, step.motion.control_points(), detail::test_points(step.motion, vertices)};
}
std::array<Index, 4> vertices_of(std::size_t query) {
  const Index v = 4 * static_cast<Index>(query);
  return {v, v + 1, v + 2, v + 3};
}

/// Features that are exactly `separation` apart at `touch`, up to two units in the last place, and not nearer before or
/// after if the control points are on a line. All coordinates are integers times `unit`.
struct AtTheSeparation {
  Points points;
  double separation, touch;
};

enum class Shape { general, along_x, degenerate };

/// Two vectors that span the features, and one that is perpendicular to both up to the rounding to integers.
std::array<Vec3, 3> frame(Number& number, Shape shape) {
  const double size = std::ldexp(1.0, 4 + number.below(36)), length = std::ldexp(1.0, 4 + number.below(27));
  Vec3 e1 = number.integers(size), e2 = number.integers(size), n = e1.cross(e2);
  if (shape == Shape::along_x) e1.x() = e2.x() = 0, n = Vec3(1, 0, 0);
  if (shape == Shape::degenerate) e2 = 2 * e1, n = e1.cross(number.vector());
  if (!(n.norm() > 0)) n = number.vector();
  return {e1, e2, (length / n.norm() * n).array().round().matrix()};
}

AtTheSeparation at_the_separation(Number& number, FeatureKind kind, int control_points, Shape shape, double far,
                                  double unit) {
  const auto [e1, e2, normal] = frame(number, shape);
  const double i = number.below(9), j = number.below(9);  // sixteenths
  const Vec3 origin = number.integers(far), at_touch = normal.norm() > 0 ? normal : Vec3(0, 0, 1);
  AtTheSeparation made;
  const int when = number.below(control_points);
  made.touch = when / (control_points - 1.0);
  for (int c = 0; c < control_points; ++c) {
    // The distance grows before and after the touch. In the middle of a curve, (3 + 2 * -1 + 3) / 4 = 1.
    const bool in_middle = control_points == 3 && when == 1;
    const double apart = in_middle ? (c == 1 ? -1 : 3) : 1 + (c == when ? 0 : number.below(3));
    const Vec3 drift = origin + number.integers(1 << 20), d = apart * at_touch;
    const Vec3 on_e1 = (i / 16) * e1, on_e2 = (j / 16) * e2;
    Points now;
    if (kind == FeatureKind::vf)
      now = {drift + d + on_e1 + on_e2, drift, drift + e1, drift + e2};
    else
      now = {drift + d - on_e1, drift + d - on_e1 + e1, drift - on_e2, drift - on_e2 + e2};
    for (const Vec3& p : now) made.points.push_back(unit * p);
  }
  const double length = unit * at_touch.norm();
  made.separation = std::nextafter(std::nextafter(length, 2 * length + unit), 2 * length + unit);
  return made;
}

/// `separation` and 7/8 of it. A test that is dropped at the smaller one shows that the first answer is not due to
/// luck.
void expect_kept(const std::vector<AtTheSeparation>& all, FeatureKind kind, int control_points, int* dropped) {
  for (const AtTheSeparation& one : all) {
    const QuerySet set(kind, control_points, one.points);
    ASSERT_LE(compare_distance(motion_of(set.step(1), kind, vertices_of(0)), one.touch, one.separation), 0);
    ASSERT_EQ(flags_of(set, one.separation), Flags{1}) << "separation " << one.separation;
    *dropped += flags_of(set, 0.875 * one.separation)[0] == 0 ? 1 : 0;
  }
}

TEST(ClearlySeparated, NothingIsDroppedAtTheSeparation) {
  std::mt19937_64 random(1);
  Number number{random};
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const Shape shape : {Shape::general, Shape::along_x, Shape::degenerate})
        // The smallest unit makes all numbers subnormal, the greatest overflows if differences are squared.
        for (const double unit : {1.0, 0x1p-20, 0x1p-1074, 0x1p-560, 0x1p600}) {
          int dropped = 0;
          std::vector<AtTheSeparation> all;
          for (int i = 0; i < 300; ++i) {
            const double far = i % 3 == 0 ? 0 : unit == 0x1p-20 ? 1e8 * 0x1p20 : 0x1p44;
            all.push_back(at_the_separation(number, kind, control_points, shape, far, unit));
          }
          expect_kept(all, kind, control_points, &dropped);
          if (unit >= 0x1p-20 && unit <= 1) {
            EXPECT_GT(dropped, control_points == 2 ? 40 : 20) << static_cast<int>(shape);
          }
        }
}

/// An edge along x ends before an edge across it. The other end is so far away that differences to it are rounded to
/// multiples of 1, which enlarges the gap from 1/4 to 1.
TEST(ClearlySeparated, RoundedDifferencesAreNoGap) {
  const double far = -0x1p53, separation = 0.25;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto at = [&](double x, double y) {
        Vec3 p = Vec3::Zero();
        p[axis] = side * x;
        p[(axis + 1) % 3] = y;
        return p;
      };
      const Points edges = {at(far + 1, 0), at(0.375, 0), at(0.625, -1), at(0.625, 1)};
      ASSERT_EQ(0.625 - (far + 1) - (0.375 - (far + 1)), 1);
      Points points = edges;
      points.insert(points.end(), edges.begin(), edges.end());
      const QuerySet set(FeatureKind::ee, 2, points);
      ASSERT_EQ(compare_distance(motion_of(set.step(1), FeatureKind::ee, vertices_of(0)), 0, separation), 0);
      EXPECT_EQ(flags_of(set, separation), Flags{1});
    }
}

/// Features of about the size 1 that are about as far apart and move by about as much.
Points random_test(Number& number, FeatureKind kind, int control_points) {
  const double far = number.below(4) == 0 ? 1e8 : 0, motion = std::ldexp(1.0, -number.below(6));
  const Vec3 offset = far * number.vector(), gap = number.vector();
  const int degenerate = number.below(8);
  Points start, points;
  for (std::size_t i = 0; i < 4; ++i) start.push_back(offset + number.vector());
  for (std::size_t i = kind == FeatureKind::vf ? 1 : 2; i < 4; ++i) start[i] += gap;
  if (degenerate == 0) start[3] = start[2];
  if (degenerate == 1)
    start[3] = kind == FeatureKind::vf ? Vec3(2 * start[2] - start[1]) : Vec3(start[2] + start[1] - start[0]);
  for (int c = 0; c < control_points; ++c)
    for (const Vec3& p : start) points.push_back(p + (c == 0 ? 0.0 : motion) * number.vector());
  return points;
}

QuerySet random_tests(std::uint64_t seed, FeatureKind kind, int control_points, int count) {
  std::mt19937_64 random(seed);
  Number number{random};
  Points points;
  for (int i = 0; i < count; ++i) {
    const Points one = random_test(number, kind, control_points);
    points.insert(points.end(), one.begin(), one.end());
  }
  return {kind, control_points, points};
}

detail::InclusionAnswer searched(const TestMotion& motion, double separation) {
  const Inclusion::Config config;
  return detail::inclusion_search(motion.kind, motion.points, motion.control_points, separation, config.time_tolerance,
                                  config.max_intervals, 1);
}

/// Greatest difference to point 0.
double size_of(const TestMotion& motion) {
  double size = 0;
  for (const double* x : motion.points)
    for (int k = 0; k < 3 * motion.control_points; ++k) size = std::max(size, std::abs(x[k] - motion.points[0][k]));
  return size;
}

/// For the separation 0 as well, with three control points.
TEST(ClearlySeparated, WhatIsDroppedStaysFurtherApart) {
  using Outcome = detail::InclusionAnswer::Outcome;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const double separation : {0.0, 0x1p-1074, 1e-3, 0.02, 0.5}) {
        const QuerySet set = random_tests(5, kind, control_points, 1000);
        const Flags keep = flags_of(set, separation);
        int dropped = 0, apart = 0;
        for (std::size_t i = 0; i < set.size(); ++i) {
          const TestMotion motion = motion_of(set.step(1), kind, vertices_of(i));
          const bool free = searched(motion, separation).outcome == Outcome::apart;
          apart += free ? 1 : 0;
          if (keep[i] != 0) continue;
          ++dropped;
          ASSERT_TRUE(free) << i;
          const double beyond = separation + detail::kClearMargin / 2 * size_of(motion);
          for (int k = 0; k <= 16; ++k) ASSERT_GT(compare_distance(motion, k / 16.0, beyond), 0) << i;
        }
        EXPECT_GT(dropped, apart * 4 / 5) << "of " << apart << ", separation " << separation;
      }
}

/// Leaves no undecided test to `exact`.
const Inclusion kSearchAlone({.exact_bits = 0});

/// The contact and the counter that the search alone would give.
void search_one(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices,
                std::vector<Contact>& contacts, std::size_t* undecided) {
  using Outcome = detail::InclusionAnswer::Outcome;
  const TestMotion motion = motion_of(step, kind, vertices);
  const detail::InclusionAnswer answer = searched(motion, step.separation);
  *undecided += answer.outcome == Outcome::undecided ? 1 : 0;
  if (answer.outcome == Outcome::apart) return;
  contacts.push_back(detail::contact_at(kind, vertices, motion.points, motion.control_points, answer.toi, answer.side,
                                        step.separation));
  contacts.back().at_start = answer.at_start;
}

/// Whole blocks, the last one with an odd number of tests.
TEST(ClearlySeparated, ContactsAreThoseOfTheSearch) {
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const double separation : {0x1p-1074, 1e-9, 0.02, 0.5, 1e9}) {
        const QuerySet set = random_tests(9, kind, control_points, separation == 1e9 ? 100 : 1497);
        const Step step = set.step(1, separation);
        std::vector<Contact> expected, contacts;
        std::size_t undecided = 0;
        for (std::size_t i = 0; i < set.size(); ++i) search_one(step, kind, vertices_of(i), expected, &undecided);
        NarrowCounters counters;
        run_stage(kSearchAlone, step, kind, set.pairs(), contacts, counters);
        EXPECT_EQ(contacts, expected) << separation;
        EXPECT_EQ(counters.undecided, undecided);
      }
}

std::string differs_from_search(const Case& c) {
  OneTest test;
  test.set(c, 1);
  std::vector<Contact> expected, contacts;
  std::size_t undecided = 0;
  search_one(test.step(), c.kind, test.block().vertices(0), expected, &undecided);
  NarrowCounters counters;
  run_stage(kSearchAlone, test.step(), test.kind(), test.pairs(), contacts, counters);
  return contacts == expected && counters.undecided == undecided ? "" : "not the contact of the search" + to_text(c);
}

TEST(ClearlySeparated, ContactsOfAttacksAreThoseOfTheSearch) {
  for (const cases::Attack& attack : cases::separation_attacks()) {
    run_seeds(1, attack.cases, [&](Choices& choices) {
      const Case c = attack_test(choices, attack);
      return c.separation > 0 ? differs_from_search(c) : "";
    });
  }
  run_seeds(1, 2000, [&](Choices& choices) {
    const Case c = near_degenerate_test(choices, cases::Separation::some);
    return c.separation > 0 ? differs_from_search(c) : "";
  });
}

TEST(ClearlySeparated, AnswersDependNeitherOnTheBlockNorOnTheInstructionSet) {
  const cases::InstructionSets sets;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      const QuerySet set = random_tests(7, kind, control_points, 641);
      const Flags best = flags_of(set, 0.02);
      sets.with_each([&](const char* name) { EXPECT_EQ(flags_of(set, 0.02), best) << name; });
      TestBlock block;
      for (std::size_t i = 0; i < set.size(); ++i) {
        block.gather(set.step(1, 0.02), kind, set.pairs().subspan(i, 1));
        std::array<std::uint8_t, 8> keep;
        keep.fill(1);
        detail::drop_clearly_separated(block, 0.02, keep);
        ASSERT_EQ(keep[0], best[i]) << i;
      }
    }
}

/// Differences that are infinite, or whose products are, prove nothing.
TEST(ClearlySeparated, OverflowKeepsTests) {
  const double huge = 0x1.8p1023;
  const Points apart = {{-huge, 0, 0}, {huge, 0, 0}, {huge, 1, 0}, {huge, 0, 1}};
  Points points = apart;
  points.insert(points.end(), apart.begin(), apart.end());
  EXPECT_EQ(flags_of({FeatureKind::vf, 2, points}, 1), Flags{1});
  for (Vec3& p : points) p *= 0x1p-40;
  EXPECT_EQ(flags_of({FeatureKind::vf, 2, points}, 1), Flags{0});
  EXPECT_EQ(flags_of({FeatureKind::vf, 2, points}, 0x1p1000), Flags{1});
}

}  // namespace
}  // namespace volccd::test::clearly_separated
