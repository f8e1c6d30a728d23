// The elementary test of 2011 compared with exact arithmetic, and properties that must not change an answer.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/oracle/cases/near_degenerate.hpp>
#include <volccd/oracle/cases/test_scene.hpp>
#include <volccd/paper2011/provot.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test::provot {
namespace {

constexpr FeatureKind kKinds[] = {FeatureKind::vf, FeatureKind::ee};

std::vector<Query> random_queries(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Query> queries(n);
  for (Query& q : queries)
    for (Vec3& p : q)
      for (int k = 0; k < 3; ++k) p[k] = random.uniform(-1, 1);
  return queries;
}

ExactAnswer truth_of(const QuerySet& set, std::size_t i) {
  const Step step = set.step();
  TestMotion motion{set.kind(), 2, {}};
  for (std::size_t p = 0; p < 4; ++p) motion.points[p] = step.motion.at(static_cast<Index>(4 * i + p));
  return exact_first_touch(motion);
}

TEST(Provot, AgreesWithExactArithmeticOnRandomTests) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, random_queries(6000, 31));
    const std::vector<Contact> contacts = set.test(Provot());
    std::size_t next = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      const ExactAnswer truth = truth_of(set, i);
      const bool found = next < contacts.size() && QuerySet::query_of(contacts[next]) == i;
      ASSERT_EQ(found, truth.touches) << i;
      if (!found) continue;
      ASSERT_NEAR(contacts[next++].toi, truth.toi, 1e-10) << i;
    }
    EXPECT_EQ(next, contacts.size());
    EXPECT_GT(next, 300u);
  }
}

TEST(Provot, ContactsAreThoseOfCubic) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, random_queries(6000, 32));
    const std::vector<Contact> found = set.test(Provot()), expected = set.test(Cubic());
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].kind, kind);
      ASSERT_EQ(found[i].vertices, expected[i].vertices);
      ASSERT_NEAR(found[i].toi, expected[i].toi, 1e-10);
      ASSERT_LT((found[i].normal - expected[i].normal).norm(), 1e-6);
      ASSERT_LT((found[i].point - expected[i].point).norm(), 1e-8);
      for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(found[i].weights[k], expected[i].weights[k], 1e-6);
      EXPECT_FALSE(found[i].at_start);
    }
  }
}

/// Points that touch at t = 0 exactly; afterwards they move as `moved` says.
Query at_start(FeatureKind kind, const Vec3& moved) {
  Query q;
  if (kind == FeatureKind::vf)
    q = {Vec3(0.25, 0.25, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  else
    q = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 1, 0)};
  for (std::size_t i = 0; i < 4; ++i) q[i + 4] = q[i];
  q[4] += moved;
  if (kind == FeatureKind::ee) q[5] += moved;
  return q;
}

TEST(Provot, ContactsAtTheStartHaveTimeZero) {
  for (const FeatureKind kind : kKinds)
    for (const double z : {1.0, -1.0, 0.0}) {
      const QuerySet set(kind, {at_start(kind, {0, 0, z})});
      const std::vector<Contact> contacts = set.test(Provot());
      ASSERT_EQ(contacts.size(), 1u);
      EXPECT_EQ(contacts[0].toi, 0);
      EXPECT_TRUE(contacts[0].at_start);
      // The normal points to where the first feature was before, with the motion continued backwards.
      EXPECT_EQ(contacts[0].normal.z(), z == 0 ? 0.0 : -z);
    }
}

TEST(Provot, ParallelEdgesMeetAndAreCounted) {
  // The edges are parallel at t = 1, when they arrive on one line: first overlapping, then beside each other.
  const Query q = {Vec3(0, 0.5, 1), Vec3(1, -0.5, 1), Vec3(0.5, 0, 0), Vec3(1.5, 0, 0),
                   Vec3(0, 0, 0),   Vec3(1, 0, 0),    Vec3(0.5, 0, 0), Vec3(1.5, 0, 0)};
  Query beside = q;
  for (const std::size_t i : {2u, 3u, 6u, 7u}) beside[i].x() += 0.75;
  const QuerySet parallel(FeatureKind::ee, {q, beside});
  NarrowCounters counters;
  const std::vector<Contact> contacts = parallel.test(Provot(), 1, &counters);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].vertices[0], 0u);
  EXPECT_EQ(contacts[0].toi, 1);
  EXPECT_EQ(counters.degenerate, 2u);
}

TEST(Provot, LatestTimeOnlyDropsLaterContacts) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, random_queries(3000, 33));
    const std::vector<Contact> all = set.test(Provot());
    std::vector<double> times = {0, 0.25, 0.5};
    for (std::size_t i = 0; i < all.size(); i += all.size() / 40) {
      times.push_back(all[i].toi);
      times.push_back(std::nextafter(all[i].toi, 0.0));
    }
    for (const double t_max : times) {
      std::vector<Contact> expected;
      for (const Contact& c : all)
        if (c.toi <= t_max) expected.push_back(c);
      EXPECT_EQ(set.test(Provot(), t_max), expected) << t_max;
    }
  }
}

TEST(Provot, ToleranceLetsWeightsOutside) {
  // A vertex that passes a triangle's edge at a distance of 1e-5.
  Query q = {Vec3(0.5, -1e-5, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  for (std::size_t i = 0; i < 4; ++i) q[i + 4] = q[i];
  q[4].z() = -1;
  const QuerySet set(FeatureKind::vf, {q});
  EXPECT_EQ(set.test(Provot()).size(), 0u);
  EXPECT_EQ(set.test(Provot({.tolerance = 1e-4})).size(), 1u);
}

/// Lattices, features within one plane, and contacts at corners and at the start, some changed by units in the last
/// place; all of ordinary size. The header of `provot` quotes these counts.
TEST(Provot, MissesFewerThanHalfOfTheNearDegenerateTests) {
  cases::TestScene scene;
  std::size_t touching = 0, missed = 0, apart = 0, invented = 0;
  for (std::uint64_t seed = 1; seed <= 8000; ++seed) {
    cases::Choices choices(seed);
    const FeatureKind kind = kKinds[seed % 2];
    const bool vf = kind == FeatureKind::vf;
    const cases::Case c = cases::near_degenerate(choices, kind, 2, vf ? 1 : 2, vf ? 3 : 2);
    scene.set(0, c);
    const FeaturePair pair = scene.pair(kind, 0);
    std::vector<Contact> contacts;
    NarrowCounters counters;
    run_stage(Provot(), scene.step(2, 0, 1), kind, {&pair, 1}, contacts, counters);
    const bool found = !contacts.empty();
    if (found) {
      ASSERT_TRUE(contacts[0].point.allFinite() && contacts[0].normal.allFinite()) << cases::to_text(c);
      ASSERT_TRUE(contacts[0].toi >= 0 && contacts[0].toi <= 1) << cases::to_text(c);
    }
    const double size = cases::Coordinates(c).size();
    if (!(size >= 0x1p-60 && size <= 0x1p60)) continue;
    const bool touches = exact_first_touch(cases::Coordinates(c).motion()).touches;
    ++(touches ? touching : apart);
    if (found != touches) ++(touches ? missed : invented);
  }
  RecordProperty("touching", static_cast<int>(touching));
  RecordProperty("missed", static_cast<int>(missed));
  RecordProperty("apart", static_cast<int>(apart));
  RecordProperty("invented", static_cast<int>(invented));
  EXPECT_GT(touching, 1000u);
  EXPECT_LT(missed, touching / 2);
  EXPECT_LT(invented, apart / 2);
}

}  // namespace
}  // namespace volccd::test::provot
