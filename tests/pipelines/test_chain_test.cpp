// Tests pass through filters and the narrow phase: none is lost or repeated, ids and coordinates stay together, and
// blocks are full.
#include <volccd/pipelines/test_chain.hpp>

#include <thread>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>

#include "pipelines/scenes.hpp"
#include "support/all_tests.hpp"

namespace volccd {
namespace {

/// Keeps the tests for which a hash of the slots is divisible by `divisor`.
class Sieve final : public FeatureFilter {
 public:
  explicit Sieve(std::uint64_t divisor, bool selects) : divisor_(divisor), selects_(selects) {}

  bool keeps(FeaturePair pair) const { return (pair.a * 7919u + pair.b * 104729u) % divisor_ == 0; }
  /// Takes out half of what run() drops.
  std::size_t select(const Step& step, StageState&, unsigned worker, FeatureKind,
                     std::span<FeaturePair> tests) const override {
    EXPECT_EQ(worker, 3u);
    EXPECT_EQ(step.t_max, 0.5);
    if (!selects_) return tests.size();
    const auto goes = [&](FeaturePair pair) { return !keeps(pair) && pair.b % 2 == 0; };
    return static_cast<std::size_t>(std::remove_if(tests.begin(), tests.end(), goes) - tests.begin());
  }
  void run(const Step& step, StageState&, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override {
    EXPECT_EQ(worker, 3u);
    EXPECT_EQ(step.t_max, 0.5);
    EXPECT_EQ(keep.size(), block.padded_size());
    sizes.push_back(block.size());
    for (std::size_t i = 0; i < block.size(); ++i)
      if (!keeps(block.pair(i))) {
        EXPECT_FALSE(selects_ && block.pair(i).b % 2 == 0);
        keep[i] = 0;
      }
  }

  mutable std::vector<std::size_t> sizes;

 private:
  std::uint64_t divisor_;
  bool selects_;
};

/// Reports a contact for each test, whose point is the first vertex of the test at t = 0, as the block has it.
class ReportAll final : public NarrowPhase {
 public:
  void run(const Step& step, StageState&, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    EXPECT_EQ(worker, 3u);
    EXPECT_EQ(step.t_max, 0.75);
    sizes.push_back(block.size());
    counters.degenerate += block.size();
    for (std::size_t i = 0; i < block.size(); ++i) {
      EXPECT_EQ(block.vertices(i), test_vertices(step.features(), block.kind(), block.pair(i)));
      for (int c = 0; c < 2; ++c)
        for (int v = 0; v < 4; ++v)
          for (int k = 0; k < 3; ++k)
            EXPECT_EQ(block.row(c, v, k)[i], step.motion.at(block.vertices(i)[static_cast<std::size_t>(v)])[3 * c + k]);
      contacts.push_back({block.kind(), block.vertices(i), 0, Vec3::Zero(), {}, Vec3::Zero(), false});
    }
  }

  /// Finds the contacts of some tests at the start.
  static bool lasts(FeaturePair pair) { return (pair.a + pair.b) % 3 == 0; }
  void find_at_start(const Step&, const TestBlock& block, std::vector<Contact>& contacts,
                     std::span<std::uint8_t> keep) const override {
    ++searches;
    EXPECT_GE(keep.size(), block.padded_size());
    for (std::size_t i = 0; i < block.size(); ++i) {
      EXPECT_EQ(keep[i], 1);
      if (!lasts(block.pair(i))) continue;
      contacts.push_back({block.kind(), block.vertices(i), 0, Vec3::Zero(), {}, Vec3::Zero(), false});
      keep[i] = 0;
    }
  }

  mutable std::vector<std::size_t> sizes;
  mutable int searches = 0;
};

struct Bench {
  /// `selects`: of the first filter.
  explicit Bench(std::vector<std::uint64_t> divisors, bool selects = false) : statistics(divisors.size() + 1) {
    for (const std::uint64_t divisor : divisors) {
      auto sieve = std::make_unique<Sieve>(divisor, selects && filters.empty());
      sieves.push_back(sieve.get());
      filters.push_back(std::move(sieve));
    }
    for (std::size_t i = 0; i <= filters.size(); ++i) states.push_back(std::make_unique<StageState>());
  }

  /// The tests are added in parts of random lengths.
  void run(const Step& step, const std::vector<FeaturePair>& vf, const std::vector<FeaturePair>& ee, Random& random) {
    TestStages stages{filters, narrow, states};
    stages.given = given;
    chain.start(step, stages, statistics, 3);
    chain.prune(0.5);
    std::array<std::size_t, 2> next{};
    for (bool more = true; more;) {
      more = false;
      for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
        const std::vector<FeaturePair>& all = kind == FeatureKind::vf ? vf : ee;
        std::size_t& at = next[static_cast<std::size_t>(kind)];
        const std::size_t length = std::min<std::size_t>(all.size() - at, random.below(300));
        std::vector<FeaturePair> part(all.begin() + static_cast<std::ptrdiff_t>(at),
                                      all.begin() + static_cast<std::ptrdiff_t>(at + length));
        chain.add(kind, part);
        at += length;
        more |= at < all.size();
      }
    }
    chain.finish();
  }

  std::vector<std::unique_ptr<FeatureFilter>> filters;
  std::vector<Sieve*> sieves;
  ReportAll narrow;
  std::vector<std::unique_ptr<StageState>> states;
  std::vector<StageStatistics> statistics;
  bool given = false;
  TestChain chain;
};

/// Tests of a list with a separation. A filter of a region may leave tests to other ranks.
TEST(TestChain, FindsContactsThatLastBeforeTheFilters) {
  const test::Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 1, 1), 3, 0.1);
  const Features& features = scene.topology.features();
  const auto vf = test::all_tests(features, FeatureKind::vf), ee = test::all_tests(features, FeatureKind::ee);
  Random random(17);
  const auto run = [&](Bench& bench, const ObjectFilter& filter, double separation, const Region& region = {}) {
    Step step{scene.topology, scene.motion, filter, separation, 0.75};
    step.piece.region = region;
    bench.given = true;
    bench.run(step, vf, ee, random);
    std::array<std::vector<FeaturePair>, 2> found, expected;
    const bool searches = separation > 0 && region.is_all();
    for (const Contact& contact : bench.chain.contacts())
      found[static_cast<std::size_t>(contact.kind)].push_back(contact.features);
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      for (const FeaturePair pair : kind == FeatureKind::vf ? vf : ee)
        if (step.asks_for(kind, pair) && ((searches && ReportAll::lasts(pair)) || bench.sieves[0]->keeps(pair)))
          expected[static_cast<std::size_t>(kind)].push_back(pair);
    for (std::size_t kind = 0; kind < 2; ++kind) {
      std::ranges::sort(found[kind]);
      std::ranges::sort(expected[kind]);
      EXPECT_EQ(found[kind], expected[kind]);
      EXPECT_EQ(bench.chain.tests(static_cast<FeatureKind>(kind)), expected[kind].size());
    }
    EXPECT_EQ(bench.narrow.searches > 0, searches);
    EXPECT_EQ(bench.statistics[1].in, bench.statistics[1].out);
    const std::vector<std::size_t>& sizes = bench.sieves[0]->sizes;
    const std::size_t full = static_cast<std::size_t>(std::ranges::count(sizes, TestBlock::kCapacity));
    // Blocks of the filter are full, but for the last of each kind.
    EXPECT_GE(full + (searches ? 2 : sizes.size()), sizes.size());
  };
  const ObjectFilter everything, inter(PairScope::inter);
  ObjectFilter some;
  some.exclude(1, 2);
  for (const ObjectFilter* filter : {&everything, &inter, static_cast<const ObjectFilter*>(&some)}) {
    Bench with({5}), without({5}), in_region({5});
    run(with, *filter, 0.1);
    run(without, *filter, 0);
    run(in_region, *filter, 0.1, {.low = Vec3(0.5, 0.5, 0.5)});
  }
}

TEST(TestChain, KeepsWhatAllFiltersKeepWhicheverWayTestsCome) {
  const test::Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 1, 1), 3, 0.1);
  const ObjectFilter everything;
  const Step step{scene.topology, scene.motion, everything, 0, 0.75};
  const Features& features = scene.topology.features();
  const auto vf = test::all_tests(features, FeatureKind::vf), ee = test::all_tests(features, FeatureKind::ee);
  ASSERT_GT(ee.size(), 1000u);
  Random random(11);
  const std::vector<std::vector<std::uint64_t>> chains{{}, {1}, {2}, {3, 5}, {1, 2, 1}, {100}};
  for (std::size_t run = 0; run < 2 * chains.size(); ++run) {
    const auto& divisors = chains[run / 2];
    Bench bench(divisors, run % 2 == 1);
    std::vector<Contact> expected;
    std::vector<std::uint64_t> kept(divisors.size() + 1, 0);
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      for (const FeaturePair pair : kind == FeatureKind::vf ? vf : ee) {
        std::size_t stage = 0;
        while (stage < bench.sieves.size() && bench.sieves[stage]->keeps(pair)) ++kept[stage++];
        if (stage < bench.sieves.size()) continue;
        expected.push_back({kind,
                            test_vertices(features, kind, pair),
                            0,
                            Vec3::Zero(),
                            {},
                            Vec3::Zero(),
                            false,
                            pair,
                            {kNone, kNone}});
      }
    bench.run(step, vf, ee, random);
    std::vector<Contact> found = bench.chain.contacts();
    std::sort(found.begin(), found.end(), canonical_less);
    std::sort(expected.begin(), expected.end(), canonical_less);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(bench.chain.counters().degenerate, expected.size());
    EXPECT_EQ(bench.chain.tests(FeatureKind::vf) + bench.chain.tests(FeatureKind::ee), expected.size());
    for (std::size_t i = 0; i <= divisors.size(); ++i) {
      EXPECT_EQ(bench.statistics[i].in, i == 0 ? vf.size() + ee.size() : kept[i - 1]) << i;
      EXPECT_EQ(bench.statistics[i].out, i < divisors.size() ? kept[i] : expected.size()) << i;
    }
  }
}

TEST(TestChain, LaterStagesRunOnFullBlocks) {
  const test::Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 1, 1), 3, 0.1);
  const ObjectFilter everything;
  const Step step{scene.topology, scene.motion, everything, 0, 0.75};
  Random random(12);
  Bench bench({10, 3});
  bench.run(step, {}, test::all_tests(scene.topology.features(), FeatureKind::ee), random);
  for (const std::vector<std::size_t>& sizes : {bench.sieves[1]->sizes, bench.narrow.sizes}) {
    ASSERT_FALSE(sizes.empty());
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i) EXPECT_EQ(sizes[i], TestBlock::kCapacity);
  }
}

TEST(StageClock, ChargesTheInnermostAlone) {
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  const auto start = std::chrono::steady_clock::now();
  StageClock clock;
  double outer = 0, inner = 0;
  {
    const StageTimer first(clock, outer);
    {
      const StageTimer second(clock, inner);
      pause();
      const StageTimer nobody(clock);
      pause();
    }
    pause();
  }
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_FALSE(clock.running());
  EXPECT_GE(inner, 0.02);
  EXPECT_GE(outer, 0.02);
  EXPECT_GE(wall - inner - outer, 0.02) << "charged twice, or to somebody";
}

}  // namespace
}  // namespace volccd
