// Contacts of several ranks against those of the whole mesh.
#include <volccd/distributed/in_process_detector.hpp>

#include <stdexcept>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/step_runner.hpp>

#include "distributed/rank_numbers.hpp"
#include "distributed/registry.hpp"
#include "support/one_step.hpp"

namespace volccd::distributed {
namespace {

using cases::Scene;

/// The presets that are not approximate, with decided tests, and VolCCD+ with a flood that declines nothing.
std::vector<PipelineSpec> specs() {
  std::vector<PipelineSpec> result;
  for (PipelineSpec spec : registry().pipelines()) {
    if (Pipeline(registry(), spec).guarantee() == Guarantee::approximate) continue;
    registry().apply_setting(spec, "inclusion.undecided=exact");
    result.push_back(spec);
    if (!spec.flood) continue;
    for (const char* setting : {"boundary-flood.max_boundary_fraction=1", "boundary-flood.max_suspect_fraction=1",
                                "boundary-flood.max_divided_fraction=1"})
      registry().apply_setting(spec, setting);
    spec.name += " always flooded";
    result.push_back(spec);
  }
  return result;
}

std::vector<Scene> scenes() {
  std::vector<Scene> all = cases::small_scenes(3, 0.15);
  all.push_back(cases::colliding("block of tetrahedra", block(ElementType::tetrahedron, 3, 2, 2), 4, 0.05));
  all.push_back(cases::colliding("jittered block", block(ElementType::tetrahedron, 2, 2, 1), 5, 0.4));
  return all;
}

/// With control points in between.
Motion curved(const Motion& motion, std::uint64_t seed) {
  std::vector<Vec3> x0, middle, x1;
  for (Index v = 0; v < motion.vertex_count(); ++v) {
    x0.push_back(motion.point(v, 0));
    x1.push_back(motion.point(v, 1));
    middle.push_back((x0.back() + x1.back()) / 2);
  }
  return Motion::quadratic(x0, jittered(middle, 0.2, seed), x1);
}

void expect_same(const StepResult& whole, const StepResult& ranks) {
  EXPECT_TRUE(whole.contacts == ranks.contacts);
  EXPECT_EQ(whole.initial_overlaps, ranks.initial_overlaps);
  EXPECT_EQ(whole.statistics.contacts, ranks.statistics.contacts);
  EXPECT_EQ(whole.statistics.contacts_at_start, ranks.statistics.contacts_at_start);
  EXPECT_EQ(whole.statistics.earliest_toi, ranks.statistics.earliest_toi);
  for (std::size_t i = 0; i < std::min(whole.contacts.size(), ranks.contacts.size()); ++i) {
    EXPECT_EQ(whole.contacts[i].features, ranks.contacts[i].features);
    EXPECT_EQ(whole.contacts[i].elements, ranks.contacts[i].elements);
  }
}

constexpr int kSomeNumbers[] = {2, 7, 16};

struct Asked {
  double separation = 0;
  ObjectFilter filter = {};
  bool leave_out_shell_neighbours = false;
  Request request = {};
  std::span<const int> ranks = kSomeNumbers;
};

/// Compares the numbers of ranks. Returns the number of contacts.
std::size_t compare(const PipelineSpec& spec, const Topology& topology, const Motion& motion, const Asked& query) {
  StepRunner runner(Pipeline(registry(), spec), {.separation = query.separation,
                                                 .filter = query.filter,
                                                 .leave_out_shell_neighbours = query.leave_out_shell_neighbours});
  const StepResult& whole = runner.run(topology, motion, query.request);
  for (const int ranks : query.ranks) {
    SCOPED_TRACE(spec.name + ", ranks: " + std::to_string(ranks));
    InProcessDetector detector(ranks, registry(), spec,
                               {.separation = query.separation,
                                .filter = query.filter,
                                .leave_out_shell_neighbours = query.leave_out_shell_neighbours});
    expect_same(whole, detector.step(topology, motion, query.request));
    std::uint64_t found = 0, elements = 0, copies = 0;
    for (const RankStatistics& rank : detector.statistics()) {
      found += rank.contacts;
      elements += rank.elements;
      copies += rank.copies;
    }
    if (query.request.query == Query::all) {
      EXPECT_EQ(found, whole.contacts.size());
    }
    EXPECT_EQ(elements, topology.mesh().element_count() + copies);
  }
  return whole.contacts.size();
}

std::size_t compare_scenes(const Asked& query, bool quadratic = false) {
  std::size_t contacts = 0;
  for (const Scene& scene : scenes())
    for (const PipelineSpec& spec : specs()) {
      SCOPED_TRACE(scene.name);
      contacts += compare(spec, scene.topology, quadratic ? curved(scene.motion, 9) : scene.motion, query);
    }
  return contacts;
}

TEST(InProcessDetector, ContactsAndOverlapsAreThoseOfTheWhole) {
  EXPECT_GT(compare_scenes({.request = {.initial_overlaps = true}, .ranks = test::kRankNumbers}), 1000u);
}

TEST(InProcessDetector, WithSeparation) {
  EXPECT_GT(compare_scenes({.separation = 0.02, .request = {.initial_overlaps = true}}), 1000u);
}

TEST(InProcessDetector, QuadraticMotion) { EXPECT_GT(compare_scenes({}, true), 1000u); }

TEST(InProcessDetector, BetweenObjects) {
  for (const PairScope scope : {PairScope::inter, PairScope::intra})
    EXPECT_GT(compare_scenes({.filter = ObjectFilter(scope)}), 10u);
}

TEST(InProcessDetector, First) { EXPECT_GT(compare_scenes({.request = {.query = Query::first}}), 10u); }

/// Coordinates of a lattice, also of the centres of moving boxes, where the cuts are.
TEST(InProcessDetector, FeaturesOnCuts) {
  for (const double separation : {0.0, 1.0}) {
    Shape both;
    both.append(block(ElementType::hexahedron, 3, 2, 1), 1);
    Shape other = block(ElementType::tetrahedron, 2, 1, 1);
    both.append(other.translate(Vec3(1, 1, 2)), 2);
    std::vector<Vec3> end = both.positions;
    for (std::size_t v = both.positions.size() - other.positions.size(); v < end.size(); ++v) end[v] -= Vec3(1, 1, 1);
    const Topology topology(both.mesh());
    for (const PipelineSpec& spec : specs())
      EXPECT_GT(compare(spec, topology, Motion::linear(both.positions, end), {.separation = separation}), 20u);
  }
}

/// Elements go, and the same Detector goes on; so does the whole, with the workspace that it has.
TEST(InProcessDetector, ErosionBetweenSteps) {
  for (const PipelineSpec& spec : specs())
    for (const int ranks : {1, 3, 16}) {
      Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 6, 0.2);
      StepRunner runner(Pipeline(registry(), spec));
      InProcessDetector detector(ranks, registry(), spec);
      std::size_t contacts = 0;
      for (Index gone = 0; gone < 5; ++gone) {
        SCOPED_TRACE(spec.name + ", " + std::to_string(ranks) + " ranks, edit " + std::to_string(gone));
        expect_same(runner.run(scene.topology, scene.motion), detector.step(scene.topology, scene.motion));
        contacts += runner.result().contacts.size();
        scene.topology.apply({.removed = {5 * gone, 5 * gone + 2, 140 - gone}});
      }
      EXPECT_GT(contacts, 100u);
    }
}

/// Pieces are kept while their elements are nearly the same, and made anew if not.
TEST(InProcessDetector, MotionsOfSeveralSizes) {
  Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 4, 3, 2), 6, 0.1);
  const PipelineSpec spec = specs().front();
  InProcessDetector detector(7, registry(), spec);
  StepRunner runner{Pipeline(registry(), spec)};
  Motion part;
  for (const double end : {1.0, 0.99, 0.5, 0.1, 0.7, 1.0}) {
    part.set_part(scene.motion, 0, end);
    expect_same(runner.run(scene.topology, part), detector.step(scene.topology, part));
  }
}

/// While a list holds, features pass from region to region, and ranks get other pieces and other regions.
TEST(InProcessDetector, CandidateListsOfSubsteps) {
  constexpr int kSubsteps = 40;
  const Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 6, 0.3);
  for (const PipelineSpec& spec : specs())
    for (const int ranks : {3, 7}) {
      SCOPED_TRACE(spec.name + ", ranks: " + std::to_string(ranks));
      StepRunner runner(Pipeline(registry(), spec), {.separation = 0.05});
      InProcessDetector detector(
          ranks, registry(), spec,
          {.separation = 0.05, .lists = {.use = ListConfig::Use::always, .budget = 0.01, .steps = 10}});
      Motion part;
      std::uint64_t contacts = 0, reused = 0;
      for (int i = 0; i < kSubsteps; ++i) {
        part.set_part(scene.motion, static_cast<double>(i) / kSubsteps, static_cast<double>(i + 1) / kSubsteps);
        expect_same(runner.run(scene.topology, part), detector.step(scene.topology, part));
        const Statistics& statistics = detector.result().statistics;
        contacts += statistics.contacts;
        reused += statistics.reused_steps;
        EXPECT_LE(statistics.list_steps + statistics.refreshed_steps + statistics.reused_steps, 1u);
      }
      EXPECT_GT(contacts, 500u);
      EXPECT_GT(reused, 5u);
    }
}

TEST(InProcessDetector, ShellNeighboursAreLeftOut) {
  const Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 6, 0.3);
  for (const PipelineSpec& spec : specs()) {
    const std::size_t contacts = compare(spec, scene.topology, scene.motion, {.leave_out_shell_neighbours = true});
    EXPECT_GT(contacts, 10u);
    EXPECT_LT(contacts, compare(spec, scene.topology, scene.motion, {}));
  }
}

/// Throws if it is told to.
class FailingExecutor final : public Executor {
 public:
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    if (fails) throw std::runtime_error("no thread");
    serial_executor().parallel_for(n, grain, body);
  }
  bool fails = false;
};

/// The ranks have the other mesh when the step fails.
TEST(InProcessDetector, AfterAFailureWithAnotherMesh) {
  const Scene first = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 6, 0.2);
  const Scene other = cases::colliding("block", block(ElementType::tetrahedron, 2, 2, 2), 7, 0.2);
  const PipelineSpec spec = specs().front();
  FailingExecutor executor;
  InProcessDetector detector(3, registry(), spec, {.executor = &executor});
  StepRunner runner{Pipeline(registry(), spec)};
  detector.step(first.topology, first.motion);
  executor.fails = true;
  EXPECT_THROW(detector.step(other.topology, other.motion), RankError);
  executor.fails = false;
  expect_same(runner.run(first.topology, first.motion), detector.step(first.topology, first.motion));
  EXPECT_GT(runner.result().contacts.size(), 10u);
}

TEST(InProcessDetector, RefusesWhatItCannotDo) {
  const PipelineSpec& spec = registry().pipeline("VolCCD+");
  EXPECT_THROW(InProcessDetector(0, registry(), spec), ConfigError);
  EXPECT_THROW(InProcessDetector(2, registry(), spec, {.separation = -1}), RankError);
  EXPECT_THROW(InProcessDetector(2, registry(), spec, {.lists = {.use = ListConfig::Use::always, .budget = -1}}),
               RankError);
  const Scene scene = cases::colliding("cell", block(ElementType::hexahedron, 1, 1, 1), 1, 0.1);
  InProcessDetector detector(2, registry(), spec);
  EXPECT_THROW(detector.step(scene.topology, scene.motion, {.ends = true}), ConfigError);
  TestBatch tests;
  EXPECT_THROW(detector.step(scene.topology, scene.motion, {.candidates = &tests}), ConfigError);
  EXPECT_THROW(detector.step(scene.topology, Motion(3, 2)), InputError);
  InProcessDetector of_shells(2, registry(), spec, {.leave_out_shell_neighbours = true});
  EXPECT_THROW(of_shells.step(scene.topology, scene.motion), ConfigError);
}

}  // namespace
}  // namespace volccd::distributed
