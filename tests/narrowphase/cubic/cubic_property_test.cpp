// Answers do not depend on the order of points, the batch, the instruction set and t_max.
#include <cstring>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/narrowphase/detail/coplanarity_block.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test::cubic_property {
namespace {

constexpr FeatureKind kKinds[] = {FeatureKind::vf, FeatureKind::ee};

/// Random pairs. Some have coordinates on a coarse lattice, so that many touch, and some of these lie in one plane.
std::vector<Query> mixed_queries(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Query> queries(n);
  for (std::size_t i = 0; i < n; ++i)
    for (Vec3& p : queries[i])
      for (int k = 0; k < 3; ++k)
        p[k] = i % 2 ? random.uniform(-1, 1) : k == 2 && i % 4 == 0 ? 0 : static_cast<double>(random.below(4)) - 1;
  return queries;
}

TEST(CubicProperty, OrderOfPointsDoesNotMatter) {
  Random random(21);
  for (const FeatureKind kind : kKinds) {
    std::vector<Query> queries(3000), permuted;
    for (Query& q : queries)
      for (Vec3& p : q) p = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    std::vector<bool> flipped;
    for (const Query& q : queries) {
      std::array<std::size_t, 4> order = {0, 1, 2, 3};
      const std::uint64_t draw = random.next();
      if (kind == FeatureKind::vf) {
        std::swap(order[1], order[1 + draw % 3]);
        if (draw & 64) std::swap(order[2], order[3]);
      } else {
        if (draw & 1) std::swap(order[0], order[1]);
        if (draw & 2) std::swap(order[2], order[3]);
        if (draw & 4) std::swap(order[0], order[2]), std::swap(order[1], order[3]);
      }
      flipped.push_back(kind == FeatureKind::ee && (draw & 4));
      Query p;
      for (std::size_t i = 0; i < 8; ++i) p[i] = q[order[i % 4] + i / 4 * 4];
      permuted.push_back(p);
    }
    const QuerySet a(kind, queries), b(kind, permuted);
    const std::vector<Contact> x = a.test(Cubic()), y = b.test(Cubic());
    ASSERT_EQ(x.size(), y.size());
    ASSERT_GT(x.size(), 100u);
    for (std::size_t i = 0; i < x.size(); ++i) {
      ASSERT_EQ(a.query_of(x[i]), b.query_of(y[i]));
      ASSERT_NEAR(x[i].toi, y[i].toi, 1e-11);
      ASSERT_LT((x[i].point - y[i].point).norm(), 1e-9);
      const Vec3 expected = flipped[a.query_of(x[i])] ? Vec3(-x[i].normal) : x[i].normal;
      ASSERT_LT((y[i].normal - expected).norm(), 1e-6);
    }
  }
}

TEST(CubicProperty, BatchDoesNotMatter) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, mixed_queries(1000, 22));
    NarrowCounters together;
    const std::vector<Contact> all = set.test(Cubic(), 1, &together);
    std::vector<Contact> single;
    NarrowCounters apart;
    for (const FeaturePair& pair : set.pairs()) test::run_stage(Cubic(), set.step(), kind, {&pair, 1}, single, apart);
    EXPECT_EQ(all, single);
    EXPECT_EQ(together.degenerate, apart.degenerate);
    EXPECT_GT(together.degenerate, 10u);

    // The tests are repeated in another order, twice, so that each has other neighbours.
    std::vector<FeaturePair> shuffled(set.pairs().begin(), set.pairs().end());
    shuffled.insert(shuffled.end(), set.pairs().begin(), set.pairs().end());
    Random(23).shuffle(shuffled);
    std::vector<Contact> again;
    NarrowCounters counters;
    test::run_stage(Cubic(), set.step(), kind, shuffled, again, counters);
    std::stable_sort(again.begin(), again.end(), canonical_less);
    ASSERT_EQ(again.size(), 2 * all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_EQ(again[2 * i], all[i]);
      ASSERT_EQ(again[2 * i + 1], all[i]);
    }
  }
}

TEST(CubicProperty, CoplanarityFilterDoesNotMatter) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, mixed_queries(4000, 27));
    for (const bool axis_test : {false, true}) {
      const std::vector<Contact> expected = set.test(Cubic({.axis_test = axis_test}));
      EXPECT_EQ(set.test(Cubic({.axis_test = axis_test, .coplanarity = false})), expected);
    }
    // Without both filters, the roots of every test are computed.
    TestBlock tests;
    tests.gather(set.step(), kind, set.pairs().first(TestBlock::kCapacity));
    std::size_t open[2] = {};
    for (const bool coplanarity : {false, true}) {
      detail::CoplanarityBlock block;
      block.compute(tests, false, coplanarity);
      for (std::size_t i = 0; i < tests.size(); ++i) open[coplanarity] += block.open(i) ? 1 : 0;
    }
    EXPECT_EQ(open[false], TestBlock::kCapacity);
    EXPECT_LT(open[true], TestBlock::kCapacity - 5);
  }
}

TEST(CubicProperty, AppendsInTheOrderOfPairs) {
  const QuerySet set(FeatureKind::vf, mixed_queries(500, 24));
  std::vector<FeaturePair> reversed(set.pairs().rbegin(), set.pairs().rend());
  std::vector<Contact> contacts(1);
  contacts[0].toi = 42;
  NarrowCounters counters{5, 6};
  test::run_stage(Cubic(), set.step(), FeatureKind::vf, reversed, contacts, counters);
  EXPECT_EQ(contacts[0].toi, 42);
  EXPECT_GT(counters.degenerate, 5u);
  EXPECT_EQ(counters.undecided, 6u);
  for (std::size_t i = 2; i < contacts.size(); ++i) ASSERT_GT(set.query_of(contacts[i - 1]), set.query_of(contacts[i]));
  std::vector<Contact> none;
  test::run_stage(Cubic(), set.step(), FeatureKind::vf, {}, none, counters);
  EXPECT_TRUE(none.empty());
}

TEST(CubicProperty, InstructionSetDoesNotMatter) {
  std::int64_t targets = hwy::SupportedTargets();
  std::size_t count = 0;
  for (const FeatureKind kind : kKinds) {
    const std::vector<Query> queries = mixed_queries(2000, 25);
    const QuerySet set(kind, queries);
    const std::vector<Contact> expected = set.test(Cubic());
    for (std::int64_t rest = targets; rest != 0; rest &= rest - 1, ++count) {
      hwy::SetSupportedTargetsForTest(rest & -rest);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      EXPECT_EQ(set.test(Cubic()), expected) << hwy::TargetName(rest & -rest);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  EXPECT_GE(count, 2u);
}

TEST(CubicProperty, LatestTimeOnlyDropsLaterContacts) {
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, mixed_queries(2000, 26));
    const std::vector<Contact> all = set.test(Cubic());
    std::vector<double> times = {0, 0.25, 0.5, 1};
    for (std::size_t i = 0; i < all.size(); i += all.size() / 40) {
      times.push_back(all[i].toi);  // t_max itself belongs to the step
      times.push_back(std::nextafter(all[i].toi, 0.0));
    }
    for (const double t_max : times) {
      std::vector<Contact> expected;
      for (const Contact& c : all)
        if (c.toi <= t_max) expected.push_back(c);
      ASSERT_EQ(set.test(Cubic(), t_max), expected) << t_max;
    }
  }
}

TEST(CubicProperty, ToleranceDecidesWhatIsNear) {
  // The vertex passes the triangle's edge at a distance of 1e-6 of the size.
  const Query q = {Vec3(0.5, -1e-6, 1),  Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                   Vec3(0.5, -1e-6, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const QuerySet set(FeatureKind::vf, {q});
  EXPECT_EQ(set.test(Cubic()).size(), 0u);
  Cubic::Config config;
  config.axis_test = false;
  EXPECT_EQ(set.test(Cubic(config)).size(), 0u);
  config.tolerance = 1e-5;
  EXPECT_EQ(set.test(Cubic(config)).size(), 1u);
}

TEST(CubicProperty, AxisTestChangesNoContact) {
  Cubic::Config without;
  without.axis_test = false;
  for (const FeatureKind kind : kKinds) {
    const QuerySet set(kind, mixed_queries(4000, 27));
    EXPECT_EQ(set.test(Cubic()), set.test(Cubic(without)));
  }
}

TEST(CubicDescriptor, MakesFromOptions) {
  const StageDescriptor<NarrowPhase> descriptor = describe_cubic();
  EXPECT_EQ(descriptor.name, "cubic");
  EXPECT_EQ(descriptor.guarantee, Guarantee::approximate);
  const auto narrow = descriptor.make({{"tolerance", "1e-6"}, {"axis_test", "false"}});
  EXPECT_EQ(narrow->max_control_points(), 2);
  EXPECT_FALSE(narrow->handles_separation());
  EXPECT_THROW(descriptor.make({{"tolerance", "0"}}), ConfigError);
  EXPECT_THROW(descriptor.make({{"tolerence", "1e-6"}}), ConfigError);
}

}  // namespace
}  // namespace volccd::test::cubic_property
