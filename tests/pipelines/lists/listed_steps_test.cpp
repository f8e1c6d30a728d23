// Steps with candidate lists have the contacts of fresh steps, bit for bit, whatever the motion does.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/pipelines/detector.hpp>

#include "pipelines/lists/listed_steps.hpp"

namespace volccd::test {
namespace {

/// Motions of a mesh, one after the other: vertices go on, shake, rest, jump and come back.
class Course {
 public:
  Course(std::vector<Vec3> positions, double pace, std::uint64_t seed)
      : home_(positions), x_(std::move(positions)), speed_(x_.size(), Vec3::Zero()), pace_(pace), random_(seed) {
    change_speeds();
  }

  Motion next(int control_points) {
    const std::vector<Vec3> from = x_;
    std::vector<Vec3> middle(x_.size());
    const std::uint64_t kind = random_.below(8);
    if (kind == 0) change_speeds();
    if (kind == 1) x_ = home_;                                                 // all come back
    if (kind == 2) x_[random_.below(x_.size())] += random_vector(random_, 2);  // one jumps
    if (kind != 3)                                                             // or all rest
      for (std::size_t v = 0; v < x_.size(); ++v)
        x_[v] += speed_[v] + (kind == 4 ? random_vector(random_, pace_) : Vec3::Zero());
    for (std::size_t v = 0; v < x_.size(); ++v)
      middle[v] = 0.5 * (from[v] + x_[v]) + random_vector(random_, 0.3 * pace_);
    return control_points == 2 ? Motion::linear(from, x_) : Motion::quadratic(from, middle, x_);
  }

  void add_vertex(const Vec3& at) { home_.push_back(at), x_.push_back(at), speed_.push_back(Vec3::Zero()); }
  const std::vector<Vec3>& positions() const { return x_; }

 private:
  void change_speeds() {
    const Vec3 common = random_vector(random_, pace_);
    for (Vec3& speed : speed_) speed = common + random_vector(random_, 0.3 * pace_);
  }

  std::vector<Vec3> home_, x_, speed_;
  double pace_;
  Random random_;
};

/// How the lists of a run are made.
struct Lists {
  double budget, steps;
};
constexpr Lists kLists[] = {{0.05, 0}, {0.02, 8}, {0.3, 3}, {0, 5}, {1e-310, 0}};

/// Removes some elements, or adds removed ones and one on a new vertex, and changes the object of an element.
void edit(Topology& topology, Course& course, std::vector<ElementSpec>& out, Random& random) {
  const Mesh& mesh = topology.mesh();
  TopologyEdit edit;
  std::int64_t next = 1000 + mesh.vertex_count();
  const bool adds = random.below(2) == 0;
  if (adds) {
    edit.added = std::move(out);
    out.clear();
    const Index n = mesh.vertex_count();
    edit.new_vertex_ids = {mesh.vertex_ids().back() + 1};
    edit.added.push_back({.type = ElementType::triangle, .vertices = {0, 1, n}, .object = 2, .id = next});
    // An element changes its object, and with it the pairs that a filter asks for.
    for (Index o = 0; o < mesh.element_slots() && edit.removed.empty(); ++o)
      if (mesh.is_live(o) && random.below(3) == 0) {
        edit.removed.push_back(o);
        edit.added.push_back(mesh.spec(o));
        edit.added.back().object = 3 - edit.added.back().object;
      }
    course.add_vertex(course.positions()[0] + random_vector(random, 1));
    topology.apply(edit);
    return;
  }
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && random.below(9) == 0) edit.removed.push_back(o), out.push_back(mesh.spec(o));
  topology.apply(edit);
}

/// Compares a runner that makes lists with a fresh one over many steps.
Uses compare(const Shape& shape, const Lists& lists, double separation, int control_points, double pace, bool edits,
             std::uint64_t seed) {
  const std::string what = "budget " + std::to_string(lists.budget) + ", steps " + std::to_string(lists.steps) +
                           ", separation " + std::to_string(separation) + ", seed " + std::to_string(seed);
  Topology topology(shape.mesh());
  Course course(shape.positions, pace, seed);
  Random random(seed + 1);
  std::vector<ElementSpec> out;
  ObjectFilter filter(seed % 3 == 0 ? PairScope::inter : seed % 3 == 1 ? PairScope::intra : PairScope::all);
  if (seed % 6 == 2) filter.exclude(1, 2);
  const auto runner = [&](ListConfig config) {
    return StepRunner(Pipeline(registry(), registry().pipeline("VolCCD+")),
                      {.separation = separation, .filter = filter, .lists = config});
  };
  StepRunner fresh = runner({}), listed = runner({ListConfig::Use::always, lists.budget, lists.steps});
  Uses uses;
  for (int k = 0; k < 24; ++k) {
    if (edits && k % 3 == 2) edit(topology, course, out, random);
    if (random.below(6) == 0) {
      const double factor = std::exp2(random.uniform(-1, 1));
      for (StepRunner* const one : {&fresh, &listed}) one->set_separation(factor * one->separation());
    }
    const Motion motion = course.next(control_points);
    const Request request{.query = random.below(4) == 0 ? Query::first : Query::all,
                          .initial_overlaps = random.below(6) == 0};
    const double t_max = random.below(5) == 0 ? 0.5 : 1;
    expect_equal(fresh.run(topology, motion, request, t_max), listed.run(topology, motion, request, t_max),
                 what + ", step " + std::to_string(k));
    const Statistics& statistics = listed.result().statistics;
    uses += {statistics.reused_steps, statistics.refreshed_steps};
  }
  return uses;
}

TEST(CandidateLists, HaveTheContactsOfFreshSteps) {
  Uses uses;
  std::uint64_t seed = 0;
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::quad})
    for (const Lists& lists : kLists)
      for (const double separation : {0.0, 0.03})
        for (const int control_points : {2, 3})
          for (const double pace : {0.004, 0.05})
            uses += compare(two_bodies(block(type, 2, 2, 1)), lists, separation, control_points, pace, false, ++seed);
  EXPECT_GT(uses.reused, 700u);
}

TEST(CandidateLists, FollowEdits) {
  Uses uses;
  std::uint64_t seed = 1000;
  for (const Shape& shape : {block(ElementType::tetrahedron, 2, 2, 1), mixed_block(1, 1)})
    for (const Lists& lists : kLists)
      for (const double separation : {0.0, 0.03})
        uses += compare(two_bodies(shape), lists, separation, 2, 0.004, true, ++seed);
  EXPECT_GT(uses.reused, 60u);
  EXPECT_GT(uses.refreshed, 30u);
}

/// Far from the origin, where positions are rounded to 1.5e-8.
TEST(CandidateLists, HoldFarFromTheOrigin) {
  Uses uses;
  std::uint64_t seed = 2000;
  Shape shape = two_bodies(block(ElementType::tetrahedron, 2, 2, 1));
  shape.translate(Vec3(1e8, -1e8, 1e8));
  for (const Lists& lists : {Lists{0.05, 0}, Lists{0.02, 8}, Lists{2e-8, 8}})
    for (const double separation : {0.0, 0.03}) uses += compare(shape, lists, separation, 2, 0.004, false, ++seed);
  EXPECT_GT(uses.reused, 30u);
}

/// All scopes of pairs, and the lists that a detector makes by itself.
TEST(CandidateLists, OfDetectorsFollowTheFilterAndTheThickness) {
  std::uint64_t reused = 0;
  for (const bool thick : {false, true})
    for (const PairScope scope : {PairScope::all, PairScope::inter, PairScope::intra})
      for (const ListConfig::Use use : {ListConfig::Use::always, ListConfig::Use::automatic}) {
        const Shape shape = two_bodies(block(thick ? ElementType::quad : ElementType::tetrahedron, 2, 2, 1));
        const std::vector<double> thickness(shape.elements.size(), 0.05);
        const auto detector = [&](ListConfig lists) {
          const DetectorConfig config{.separation = 0.01, .filter = ObjectFilter(scope), .lists = lists};
          return thick ? Detector(shape.mesh(), thickness, config) : Detector(shape.mesh(), config);
        };
        Detector fresh = detector({}), listed = detector({use, 0.05, 8});
        Course course(shape.positions, 0.002, 7);
        for (int k = 0; k < 40; ++k) {
          const Motion motion = course.next(2);
          std::vector<Vec3> x0, x1;
          for (Index v = 0; v < motion.vertex_count(); ++v)
            x0.push_back(motion.point(v, 0)), x1.push_back(motion.point(v, 1));
          expect_equal(fresh.step(x0, x1), listed.step(x0, x1), "step " + std::to_string(k));
          if (use == ListConfig::Use::always) reused += listed.result().statistics.reused_steps;
        }
      }
  EXPECT_GT(reused, 60u);
}

/// Throws in the middle of some loops.
class FailingExecutor final : public Executor {
 public:
  explicit FailingExecutor(std::uint64_t seed) : random_(seed) {}
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    const bool fails = on && random_.below(60) == 0;
    serial_executor().parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
      body(begin, end, worker);
      if (fails) throw std::runtime_error("interrupted");
    });
  }
  bool on = true;

 private:
  Random random_;
};

/// After an exception, wherever it came from, the next step is as any other.
TEST(CandidateLists, SurviveInterruptions) {
  std::uint64_t thrown = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Shape shape = two_bodies(block(ElementType::tetrahedron, 2, 2, 1));
    Topology topology(shape.mesh());
    Course course(shape.positions, 0.01, seed);
    Random random(seed);
    std::vector<ElementSpec> out;
    FailingExecutor executor(seed);
    StepRunner fresh(Pipeline(registry(), registry().pipeline("VolCCD+")), {.separation = 0.02});
    StepRunner listed(Pipeline(registry(), registry().pipeline("VolCCD+")),
                      {.executor = &executor, .separation = 0.02, .lists = {ListConfig::Use::always, 0.03, 4}});
    for (int k = 0; k < 30; ++k) {
      if (k % 4 == 3) edit(topology, course, out, random);
      const Motion motion = course.next(2);
      executor.on = true;
      try {
        listed.run(topology, motion);
      } catch (const std::runtime_error&) {
        ++thrown;
        executor.on = false;
        listed.run(topology, motion);
      }
      expect_equal(fresh.run(topology, motion), listed.result(), "seed " + std::to_string(seed));
    }
  }
  EXPECT_GT(thrown, 50u);
}

TEST(CandidateLists, AreRefusedWhereTheyWouldLoseContacts) {
  PipelineSpec spec = registry().pipeline("VolCCD");
  spec.narrow_phase = {"provot"};
  const auto make = [&](ListConfig lists) { StepRunner(Pipeline(registry(), spec), {.lists = lists}); };
  EXPECT_NO_THROW(make({}));
  EXPECT_THROW(make({ListConfig::Use::automatic}), ConfigError);
  spec = registry().pipeline("VolCCD+");
  for (const double bad : {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(make({ListConfig::Use::always, bad, 1}), ConfigError);
    EXPECT_THROW(make({ListConfig::Use::always, 1, bad}), ConfigError);
  }
}

/// Tests that a caller gives are those that are performed, whatever the list has.
TEST(CandidateLists, LeaveGivenTestsAlone) {
  const Shape shape = two_bodies(block(ElementType::tetrahedron, 2, 2, 2));
  const Topology topology(shape.mesh());
  std::vector<Vec3> ends = shape.positions;
  for (Vec3& x : ends) x *= 0.1;
  const Motion motion = Motion::linear(shape.positions, ends);
  StepRunner listed(Pipeline(registry(), registry().pipeline("VolCCD+")),
                    {.separation = 0.2, .lists = {ListConfig::Use::always, 0.1, 1}});
  const std::size_t all = listed.run(topology, motion).contacts.size();
  ASSERT_GT(all, 1u);
  EXPECT_EQ(listed.result().statistics.list_steps, 1u);
  TestBatch one;
  const Contact& first = listed.result().contacts[0];
  (first.kind == FeatureKind::vf ? one.vf : one.ee).push_back(first.features);
  EXPECT_EQ(listed.run(topology, motion, {.tests = &one}).contacts.size(), 1u);
  EXPECT_EQ(listed.run(topology, motion).contacts.size(), all);
  TestBatch candidates;
  EXPECT_TRUE(listed.run(topology, motion, {.candidates = &candidates}).contacts.empty());
  EXPECT_EQ(listed.result().statistics.reused_steps, 0u);
  EXPECT_GE(candidates.size(), all);
}

/// Candidates serve other motions, in which features are in other regions.
TEST(CandidateLists, AreCollectedInAllOfSpace) {
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, jittered(shape.positions, 0.6, 3));
  PipelineSpec spec = registry().pipeline("VolCCD+");
  spec.flood.reset();
  spec.orphans->options["max_suspect_fraction"] = "1";
  StepRunner runner{Pipeline(registry(), spec)};
  const auto candidates = [&](const Region& region) {
    TestBatch tests;
    runner.run(topology, motion, {.candidates = &tests}, 1, {.region = region});
    return tests;
  };
  const Region elsewhere{.low = Vec3(9, 9, 9)};
  const TestBatch all = candidates({}), same = candidates(elsewhere);
  EXPECT_EQ(same.vf, all.vf);
  EXPECT_EQ(same.ee, all.ee);
  const auto orphans = [&](const Region& region) {
    return runner.run(topology, motion, {}, 1, {.region = region}).statistics.orphan_tests;
  };
  EXPECT_LT(orphans(elsewhere), orphans({}));
}

}  // namespace
}  // namespace volccd::test
