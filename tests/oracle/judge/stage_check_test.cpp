// check_stage() finds the errors of stages that break a promise.
#include <volccd/oracle/judge/stage_check.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/core/random.hpp>
#include <volccd/culling/assignment/all_pairs.hpp>
#include <volccd/culling/csat/csat.hpp>
#include <volccd/culling/o_set/o_set_source.hpp>
#include <volccd/narrowphase/exact/exact.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include "oracle/judge/made_stage.hpp"
#include "support/all_stages.hpp"
#include "support/allocations.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

/// A hash of some doubles, which gives the same answer for the same test in every batch.
std::uint64_t hash(std::initializer_list<double> values) {
  std::uint64_t sum = 1;
  for (const double value : values) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    sum = hash_ids(sum, bits);
  }
  return sum;
}
std::uint64_t hash(const TestBlock& block, std::size_t i) {
  return hash({block.row(0, 0, 0)[i], block.row(0, 1, 1)[i], block.row(0, 2, 2)[i], block.row(0, 3, 0)[i]});
}
std::uint64_t hash(const Step& step, ElementPair pair) {
  const Vec3 a = step.motion.point(step.mesh().vertices(pair.a)[0], 0),
             b = step.motion.point(step.mesh().vertices(pair.b)[0], 0);
  return hash({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()});
}

StageCheckConfig quick(int trials) {
  StageCheckConfig config;
  config.trials = trials;
  config.allocation_count = test::allocation_count;
  return config;
}

std::string text_of(const StageReport& report) {
  std::string text;
  for (const PromiseReport& one : report.promises)
    if (!one.kept())
      text +=
          one.promise + ": " + std::to_string(one.broken) + " of " + std::to_string(one.checked) + ", " + one.example;
  return text;
}

/// Checks the stage that `make` makes.
template <class Interface, class Make>
StageReport check_made(Make make, const StageCheckConfig& config, Guarantee guarantee = Guarantee::conservative) {
  Registry registry = test::all_stages();
  StageDescriptor<Interface> descriptor;
  descriptor.name = "made";
  descriptor.guarantee = guarantee;
  descriptor.make = [make](const OptionValues&) { return make(); };
  registry.add(descriptor);
  return check_stage(registry, "made", config);
}

/// Checks a stage made of `run`.
template <class Interface, class Run>
StageReport check(Run run, Guarantee guarantee = Guarantee::conservative, int trials = 500, bool pipelines = false) {
  StageCheckConfig config = quick(trials);
  config.pipelines = pipelines;
  return check_made<Interface>([run] { return std::make_unique<test::Made<Interface, Run>>(run); }, config, guarantee);
}

bool broken(const StageReport& report, const std::string& promise) {
  for (const PromiseReport& one : report.promises)
    if (one.promise == promise) {
      EXPECT_EQ(one.kept(), one.example.empty() || !one.required);
      return !one.kept();
    }
  return false;
}

const std::string kLoses = "loses no contact", kBatch = "the answer does not depend on the batch or the worker",
                  kSteps = "the answer does not depend on earlier steps", kMemory = "allocates nothing in steady state",
                  kPipelines = "pipelines that contain it find the contacts of those that do not";

/// Most stars of the generated meshes may fold, so that the O-Set provides the orphans unless it is told not to.
TEST(StageCheck, StarOrphansKeepTheirPromisesWithoutTheOSet) {
  StageCheckConfig config = quick(test::trials(2000));
  config.options = {{"max_suspect_fraction", "1"}};
  const StageReport report = check_stage(test::all_stages(), "star-orphans", config);
  EXPECT_TRUE(report.kept()) << text_of(report);
}

// --- feature filters

TEST(StageCheck, PassesAFilterThatDoesNothing) {
  const auto report = check<FeatureFilter>([](const Step&, unsigned, const TestBlock&, std::span<std::uint8_t>) {});
  EXPECT_TRUE(report.kept()) << text_of(report);
  EXPECT_EQ(report.role, "feature-filter");
}

const auto drop_one_in_a_thousand = [](const Step&, unsigned, const TestBlock& block, std::span<std::uint8_t> keep) {
  for (std::size_t i = 0; i < block.size(); ++i)
    if (hash(block, i) % 1000 == 0) keep[i] = 0;
};

TEST(StageCheck, FindsOneContactInAThousandThatAFilterDrops) {
  const auto report = check<FeatureFilter>(drop_one_in_a_thousand);
  EXPECT_TRUE(broken(report, kLoses));
  EXPECT_FALSE(report.kept());
}

TEST(StageCheck, FindsItInPipelinesToo) {
  const auto drop_more = [](const Step&, unsigned, const TestBlock& block, std::span<std::uint8_t> keep) {
    for (std::size_t i = 0; i < block.size(); ++i)
      if (hash(block, i) % 20 == 0) keep[i] = 0;
  };
  EXPECT_TRUE(broken(check<FeatureFilter>(drop_more, Guarantee::conservative, 1, true), kPipelines));
}

TEST(StageCheck, CountsButAllowsTheLossesOfAnApproximateStage) {
  const auto report = check<FeatureFilter>(drop_one_in_a_thousand, Guarantee::approximate);
  EXPECT_TRUE(report.kept()) << text_of(report);
  for (const PromiseReport& one : report.promises) EXPECT_TRUE(one.promise != kLoses || one.broken > 0);
}

TEST(StageCheck, FindsThatAViolationRepeatsFromItsSeed) {
  const auto report = check<FeatureFilter>(drop_one_in_a_thousand);
  for (const PromiseReport& one : report.promises) {
    if (one.promise != kLoses) continue;
    ASSERT_EQ(one.example.rfind("seed ", 0), 0u) << one.example;
    StageCheckConfig config = quick(1);
    config.pipelines = false;
    config.seed = std::stoull(one.example.substr(5));
    Registry registry = test::all_stages();
    StageDescriptor<FeatureFilter> descriptor;
    descriptor.name = "made";
    descriptor.guarantee = Guarantee::conservative;
    descriptor.make = [](const OptionValues&) {
      return std::make_unique<test::Made<FeatureFilter, decltype(drop_one_in_a_thousand)>>(drop_one_in_a_thousand);
    };
    registry.add(descriptor);
    const StageReport again = check_stage(registry, "made", config);
    EXPECT_TRUE(broken(again, kLoses));
  }
}

TEST(StageCheck, FindsAFilterThatDependsOnTheBatch) {
  const auto report =
      check<FeatureFilter>([](const Step&, unsigned, const TestBlock& block, std::span<std::uint8_t> keep) {
        if (block.size() > 1)
          std::fill(keep.begin(), keep.end(), std::uint8_t{1});
        else if (block.row(0, 0, 0)[0] > 0 && block.row(1, 0, 0)[0] > 0 && block.row(0, 1, 0)[0] < 0 &&
                 block.row(1, 1, 0)[0] < 0)
          keep[0] = 0;
      });
  EXPECT_TRUE(broken(report, kBatch));
}

TEST(StageCheck, FindsAFilterThatDependsOnTheWorker) {
  const auto report =
      check<FeatureFilter>([](const Step&, unsigned worker, const TestBlock& block, std::span<std::uint8_t> keep) {
        if (worker == 2 && hash(block, 0) % 50 == 0) keep[0] = 0;
      });
  EXPECT_TRUE(broken(report, kBatch));
}

/// Leaves all tests but reverses them, or drops one in a hundred.
class Selects final : public FeatureFilter {
 public:
  explicit Selects(bool reverses) : reverses_(reverses) {}
  std::size_t select(const Step& step, StageState&, unsigned, FeatureKind kind,
                     std::span<FeaturePair> tests) const override {
    if (reverses_) {
      std::reverse(tests.begin(), tests.end());
      return tests.size();
    }
    const auto one_in_a_hundred = [&](FeaturePair pair) {
      const Vec3 p = step.motion.point(test_vertices(step.features(), kind, pair)[0], 0);
      return hash({p.x(), p.y(), p.z()}) % 100 == 0;
    };
    return static_cast<std::size_t>(std::remove_if(tests.begin(), tests.end(), one_in_a_hundred) - tests.begin());
  }
  void run(const Step&, StageState&, unsigned, const TestBlock&, std::span<std::uint8_t>) const override {}

 private:
  bool reverses_;
};

TEST(StageCheck, FindsAFilterWhoseSelectLosesOrMovesTests) {
  for (const bool reverses : {true, false}) {
    const StageReport report =
        check_made<FeatureFilter>([reverses] { return std::make_unique<Selects>(reverses); }, quick(500));
    EXPECT_TRUE(broken(report, reverses ? "select() takes tests out, and leaves the others in their order" : kLoses))
        << text_of(report);
  }
}

/// Finds a contact for the first test at the start, whatever it is.
class EarlyPhase final : public NarrowPhase {
 public:
  bool handles_separation() const override { return true; }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    inclusion_.run(step, state, worker, block, contacts, counters);
  }
  void find_at_start(const Step&, const TestBlock& block, std::vector<Contact>& contacts,
                     std::span<std::uint8_t> keep) const override {
    contacts.push_back({block.kind(), block.vertices(0), 0, Vec3::Zero(), {}, Vec3::Zero(), true});
    keep[0] = 0;
  }

 private:
  Inclusion inclusion_;
};

TEST(StageCheck, FindsANarrowPhaseWhoseContactsAtTheStartAreNotItsOwn) {
  const StageReport report = check_made<NarrowPhase>([] { return std::make_unique<EarlyPhase>(); }, quick(100));
  EXPECT_TRUE(broken(report, "find_at_start() finds contacts of run() that begin at t = 0")) << text_of(report);
}

TEST(StageCheck, FindsAFilterThatAllocates) {
  const auto report = check<FeatureFilter>([](const Step&, unsigned, const TestBlock& block, std::span<std::uint8_t>) {
    std::vector<double> sums(block.size());
    EXPECT_EQ(sums[0], 0);
  });
  EXPECT_TRUE(broken(report, kMemory));
}

TEST(StageCheck, FindsAFilterThatForgetsTheSeparation) {
  const auto report =
      check<FeatureFilter>([](const Step& step, unsigned, const TestBlock& block, std::span<std::uint8_t> keep) {
        for (std::size_t i = 0; i < block.size(); ++i) {
          double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
          for (int p = 0; p < 4; ++p)
            for (int c = 0; c < block.control_points(); ++c) {
              const int set = p < (block.kind() == FeatureKind::vf ? 1 : 2) ? 0 : 1;
              low[set] = std::min(low[set], block.row(c, p, 2)[i]);
              high[set] = std::max(high[set], block.row(c, p, 2)[i]);
            }
          if (low[0] > high[1] || low[1] > high[0]) keep[i] = 0;
        }
        (void)step;
      });
  EXPECT_TRUE(broken(report, kLoses));
}

// --- narrow phases

const auto inclusion = [](const Step& step, const TestBlock& block, std::vector<Contact>& contacts,
                          NarrowCounters& counters) {
  static const Inclusion stage{Inclusion::Config{}};
  StageState none;
  stage.run(step, none, 0, block, contacts, counters);
};

TEST(StageCheck, FindsANarrowPhaseThatLosesOneContactInTwoHundred) {
  const auto report = check<NarrowPhase>(
      [](const Step& step, unsigned, const TestBlock& block, std::vector<Contact>& contacts, NarrowCounters& counters) {
        const std::size_t begin = contacts.size();
        inclusion(step, block, contacts, counters);
        contacts.erase(std::remove_if(contacts.begin() + static_cast<std::ptrdiff_t>(begin), contacts.end(),
                                      [](const Contact& c) {
                                        return hash({c.point.x(), c.toi}) % 200 == 0;
                                      }),
                       contacts.end());
      },
      Guarantee::conservative, 100);
  EXPECT_TRUE(broken(report, kLoses));
}

TEST(StageCheck, FindsANarrowPhaseThatInventsContactsAndSaysExact) {
  const auto run = [](const Step& step, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
                      NarrowCounters& counters) { inclusion(step, block, contacts, counters); };
  EXPECT_TRUE(broken(check<NarrowPhase>(run, Guarantee::exact, 40), "invents no contact"));
  EXPECT_FALSE(broken(check<NarrowPhase>(run, Guarantee::conservative, 40), "invents no contact"));
}

TEST(StageCheck, FindsANarrowPhaseThatIsLate) {
  const auto report = check<NarrowPhase>(
      [](const Step& step, unsigned, const TestBlock& block, std::vector<Contact>& contacts, NarrowCounters& counters) {
        const std::size_t begin = contacts.size();
        inclusion(step, block, contacts, counters);
        for (std::size_t i = begin; i < contacts.size(); ++i)
          if (contacts[i].toi > 0) contacts[i].toi = std::min(contacts[i].toi * (1 + 1e-7), step.t_max);
      },
      Guarantee::conservative, 30);
  EXPECT_TRUE(broken(report, "times are never late, and early by no more than the tolerance"));
}

TEST(StageCheck, FindsANarrowPhaseThatRemembersTheStepBefore) {
  const auto report = check<NarrowPhase>(
      [step_count = std::make_shared<int>(0)](const Step& step, unsigned, const TestBlock& block,
                                              std::vector<Contact>& contacts, NarrowCounters& counters) {
        const std::size_t begin = contacts.size();
        inclusion(step, block, contacts, counters);
        if (++*step_count % 7 == 0)
          for (std::size_t i = begin; i < contacts.size(); ++i) contacts[i].normal = Vec3::Zero();
      },
      Guarantee::conservative, 20);
  EXPECT_TRUE(broken(report, kSteps) || broken(report, kBatch));
}

// --- element culling

TEST(StageCheck, FindsElementCullingThatDropsOnePairInFiveHundred) {
  const auto report = check<ElementCulling>([](const Step& step, unsigned, PairBatch& batch) {
    batch.cull([&](ElementPair pair, FeatureMask&) {
      return hash(step, pair) % 500 == 0 ? PairVerdict::disjoint : PairVerdict::keep;
    });
  });
  EXPECT_TRUE(broken(report, kLoses));
}

/// The square of a difference overflows beyond 2^512, so that the distance is infinite, but the radii are finite.
TEST(StageCheck, FindsElementCullingWhoseSquaresOverflow) {
  const auto report = check<ElementCulling>(
      [](const Step& step, unsigned, PairBatch& batch) {
        const auto sphere = [&](Index o) {
          Eigen::AlignedBox3d box;
          for (const Index v : step.mesh().vertices(o))
            for (int c = 0; c < step.motion.control_points(); ++c) box.extend(step.motion.point(v, c));
          return std::pair(Vec3(box.center()), 0.5 * box.diagonal().cwiseAbs().sum() + 1e-300);
        };
        batch.cull([&](ElementPair pair, FeatureMask&) {
          const auto [a, r] = sphere(pair.a);
          const auto [b, s] = sphere(pair.b);
          return (a - b).norm() > (r + s) * (1 + 1e-9) + step.separation ? PairVerdict::disjoint : PairVerdict::keep;
        });
      },
      Guarantee::conservative, 1000);
  EXPECT_TRUE(broken(report, kLoses));
}

TEST(StageCheck, FindsElementCullingThatMasksWhatTouches) {
  const auto report = check<ElementCulling>([](const Step& step, unsigned, PairBatch& batch) {
    batch.cull([&](ElementPair pair, FeatureMask& mask) {
      if (hash(step, pair) % 100 == 0) mask.vertices_a = 15, mask.edges_b = 63;
      return PairVerdict::keep;
    });
  });
  EXPECT_TRUE(broken(report, kLoses));
}

/// Drops pairs in which one element lies within the box of the other one at the start.
auto drop_nested(PairVerdict verdict) {
  return [verdict](const Step& step, unsigned, PairBatch& batch) {
    batch.cull([&](ElementPair pair, FeatureMask&) {
      Eigen::AlignedBox3d a, b;
      for (const Index v : step.mesh().vertices(pair.a)) a.extend(step.motion.point(v, 0));
      for (const Index v : step.mesh().vertices(pair.b)) b.extend(step.motion.point(v, 0));
      return a.contains(b) || b.contains(a) ? verdict : PairVerdict::keep;
    });
  };
}

TEST(StageCheck, FindsElementCullingThatCallsNestedElementsDisjoint) {
  const std::string promise = "drops no pair as disjoint that overlaps at the start";
  EXPECT_TRUE(broken(check<ElementCulling>(drop_nested(PairVerdict::disjoint)), promise));
  EXPECT_FALSE(broken(check<ElementCulling>(drop_nested(PairVerdict::contact_free)), promise));
}

TEST(StageCheck, FindsElementCullingThatDependsOnItsBatch) {
  const auto report = check<ElementCulling>([](const Step& step, unsigned, PairBatch& batch) {
    const bool alone = batch.size() == 1;
    batch.cull([&](ElementPair pair, FeatureMask& mask) {
      if (alone && hash(step, pair) % 4 == 0) mask.vertices_b = 0x8000'0000u;
      return PairVerdict::keep;
    });
  });
  EXPECT_TRUE(broken(report, kBatch));
}

/// Keeps the bounds of the first step, and uses them in all steps.
class StaleCulling final : public ElementCulling {
 public:
  struct State final : StageState {
    std::uint64_t version = 0;
    std::vector<double> low, high;
  };
  std::unique_ptr<StageState> make_state() const override { return std::make_unique<State>(); }
  void prepare(const Step& step, StageState& state, Executor&) const override {
    State& s = static_cast<State&>(state);
    if (s.version == step.topology.version()) return;  // this is wrong, because the motion is a different one
    s.version = step.topology.version();
    const Index n = step.mesh().element_slots();
    s.low.assign(n, HUGE_VAL), s.high.assign(n, -HUGE_VAL);
    for (Index o = 0; o < n; ++o)
      for (const Index v : step.mesh().vertices(o))
        for (int c = 0; c < step.motion.control_points(); ++c) {
          s.low[o] = std::min(s.low[o], step.motion.point(v, c).z());
          s.high[o] = std::max(s.high[o], step.motion.point(v, c).z());
        }
  }
  void run(const Step& step, StageState& state, unsigned, PairBatch& batch) const override {
    const State& s = static_cast<const State&>(state);
    batch.cull([&](ElementPair p, FeatureMask&) {
      const double gap = std::max(s.low[p.a] - s.high[p.b], s.low[p.b] - s.high[p.a]);
      return gap > step.separation * 2 ? PairVerdict::disjoint : PairVerdict::keep;
    });
  }
};

TEST(StageCheck, FindsAStateThatIsNotUpdatedForTheStep) {
  StageCheckConfig config = quick(200);
  config.pipelines = false;
  const auto make = [] { return std::make_unique<StaleCulling>(); };
  EXPECT_TRUE(broken(check_made<ElementCulling>(make, config), kLoses));
}

// --- broad phases

using PairList = std::vector<ElementPair>;

void append(PairList& to, std::span<const ElementPair> pairs) { to.insert(to.end(), pairs.begin(), pairs.end()); }

TEST(StageCheck, FindsABroadPhaseThatEmitsAPairTwice) {
  const auto report = check<BroadPhase>(
      [](const Step&, unsigned, const PairList& pairs, PairList& out) {
        append(out, pairs);
        if (pairs[0].a % 16 == 2) out.push_back(pairs[0]);
      },
      Guarantee::conservative, 100);
  EXPECT_TRUE(broken(report, "emits each pair once, in order, by a worker of the executor"));
}

TEST(StageCheck, FindsABroadPhaseThatLosesAPairInFiveHundred) {
  const auto report = check<BroadPhase>([](const Step& step, unsigned, const PairList& pairs, PairList& out) {
    for (const ElementPair& pair : pairs)
      if (hash(step, pair) % 500) out.push_back(pair);
  });
  EXPECT_TRUE(broken(report, "emits every pair that meets during the step"));
}

TEST(StageCheck, FindsABroadPhaseThatLosesPairsWithSeveralWorkers) {
  const auto report = check<BroadPhase>(
      [](const Step&, unsigned workers, const PairList& pairs, PairList& out) {
        append(out, workers == 1 || pairs.size() < 3 ? std::span(pairs) : std::span(pairs).subspan(1));
      },
      Guarantee::conservative, 100, true);
  EXPECT_TRUE(broken(report, kBatch));
  EXPECT_TRUE(broken(report, "pipelines that contain it find the same contacts with several threads"));
}

// --- assignment, orphans

const std::string kCovers = "its tests contain every feature pair that it owes";

TEST(StageCheck, FindsAnAssignmentThatLosesATest) {
  const auto report = check<Assignment>([](std::size_t begin, TestBatch& out) {
    out.vf.erase(std::remove_if(out.vf.begin() + static_cast<std::ptrdiff_t>(begin), out.vf.end(),
                                [](FeaturePair pair) { return pair.a == 3 && pair.b == 1; }),
                 out.vf.end());
  });
  EXPECT_TRUE(broken(report, kCovers));
}

TEST(StageCheck, FindsAnAssignmentThatDependsOnTheBatch) {
  const auto report = check<Assignment>([](std::size_t begin, TestBatch& out) {
    if (begin == 0 && !out.vf.empty()) out.vf.push_back(out.vf[0]);
  });
  EXPECT_TRUE(broken(report, kBatch));
}

TEST(StageCheck, FindsAnOrphanSourceThatLosesATest) {
  const auto report = check<OrphanSource>(
      [](std::size_t, TestBatch& out) { std::erase_if(out.ee, [](FeaturePair pair) { return pair.a == 5; }); });
  EXPECT_TRUE(broken(report, kCovers));
}

TEST(StageCheck, UnknownStageNamesTheKnown) {
  try {
    check_stage(test::all_stages(), "nothing");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("csat"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("kdop-bvh"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace volccd
