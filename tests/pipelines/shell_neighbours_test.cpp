// Tests of features with copies of one shell vertex are left out where a step says so.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/pipelines/lists/candidate_list.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"

namespace volccd {
namespace {

using test::registry;

const ObjectFilter kAll;
constexpr bool kKeep = false, kLeaveOut = true;

/// Shells that move from `start` to `end`, thickened.
struct Solids {
  Solids(const Shape& shape, const std::vector<Vec3>& start, const std::vector<Vec3>& end, double thickness)
      : shells(shape.mesh()), thickener(shells), topology(thickener.solid_mesh(shells)) {
    const std::vector<double> h(shells.element_slots(), thickness);
    std::vector<Vec3> x0, x1;
    thickener.positions(start, h, x0);
    thickener.positions(end, h, x1);
    motion.set_linear(x0, x1);
  }

  Step step(bool leave_out) const {
    return {.topology = topology,
            .motion = motion,
            .filter = kAll,
            .separation = separation,
            .leave_out_shell_neighbours = leave_out};
  }

  StepResult run(const std::string& pipeline, bool leave_out, unsigned threads = 1, const Request& request = {}) const {
    const Pipeline p(registry(), registry().pipeline(pipeline));
    Workspace workspace = p.make_workspace();
    const auto executor = make_executor(threads);
    StepResult result;
    p.run(step(leave_out), workspace, *executor, result, request);
    return result;
  }

  /// Decided from ids (a shell vertex has the ids 3 id to 3 id + 2), and not by the function under test.
  bool stem_from_one(FeatureKind kind, const std::array<Index, 4>& vertices) const {
    const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
    const auto id = [&](std::size_t i) { return topology.mesh().vertex_id(vertices[i]) / 3; };
    for (std::size_t i = 0; i < second; ++i)
      for (std::size_t j = second; j < 4; ++j)
        if (id(i) == id(j)) return true;
    return false;
  }

  Mesh shells;
  ShellThickener thickener;
  Topology topology;
  Motion motion;
  double separation = 0;
};

/// Two quads with a common edge as a hinge, which close like a book from the angle `from` to the angle `to`.
Solids book(double from, double to) {
  const Shape shape = block(ElementType::quad, 2, 1, 1);
  const auto folded = [&](double angle) {
    std::vector<Vec3> x = shape.positions;
    double middle = 0;
    for (const Vec3& p : x) middle = std::max(middle, p.x() / 2);
    for (Vec3& p : x)
      if (p.x() > middle) {
        const double r = p.x() - middle;
        p = Vec3(middle + r * std::cos(angle), p.y(), p.z() + r * std::sin(angle));
      }
    return x;
  };
  return Solids(shape, folded(from), folded(to), 0.3);
}

/// A sheet whose vertices move at random, and a second sheet that falls through it.
Solids crumpled(std::uint64_t seed) {
  Shape shape = block(ElementType::quad, 3, 2, 1), other = block(ElementType::triangle, 2, 2, 1);
  const std::size_t of_first = shape.positions.size();
  shape.append(other.translate(Vec3(0.3, 0.2, 2)), 1);
  const std::vector<Vec3> start = jittered(shape.positions, 0.1, seed);
  std::vector<Vec3> end = jittered(shape.positions, 0.6, seed + 1000);
  for (std::size_t i = of_first; i < end.size(); ++i) end[i].z() -= 2.2;
  return Solids(shape, start, end, 0.25);
}

/// `result` has the contacts of `every` but for those of shell neighbours. Returns how many these are.
std::size_t expect_fewer(const Solids& solids, const StepResult& every, const StepResult& result) {
  std::vector<Contact> kept;
  for (const Contact& c : every.contacts)
    if (!solids.stem_from_one(c.kind, c.vertices)) kept.push_back(c);
  EXPECT_EQ(result.contacts, kept);
  EXPECT_EQ(result.statistics.contacts, kept.size());
  double earliest = INFINITY;
  for (const Contact& c : kept) earliest = std::min(earliest, c.toi);
  EXPECT_EQ(result.statistics.earliest_toi, earliest);
  return every.contacts.size() - kept.size();
}

/// The pipelines that find the same contacts, bit for bit.
std::vector<PipelineSpec> certified_pipelines() {
  std::vector<PipelineSpec> pipelines = registry().pipelines();
  std::erase_if(pipelines, [](const PipelineSpec& spec) { return spec.narrow_phase.name != "inclusion"; });
  return pipelines;
}

TEST(ShellNeighbours, OfABookThatClosesAreLeftOut) {
  const Solids solids = book(0.2, 3.0);
  const StepResult every = solids.run("BruteForce", kKeep);
  for (const PipelineSpec& spec : certified_pipelines()) {
    SCOPED_TRACE(spec.name);
    EXPECT_EQ(solids.run(spec.name, kKeep).contacts, every.contacts);
    EXPECT_GT(expect_fewer(solids, every, solids.run(spec.name, kLeaveOut)), 0u);
  }
}

/// All pipelines leave out the same contacts, for any number of workers, and no others.
TEST(ShellNeighbours, AreLeftOutByAllPipelinesAlike) {
  std::size_t kept = 0, left_out = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const Solids solids = crumpled(seed);
    const StepResult every = solids.run("BruteForce", kKeep);
    for (const PipelineSpec& spec : certified_pipelines())
      for (const unsigned threads : {1u, 3u}) {
        SCOPED_TRACE(spec.name + " " + std::to_string(threads));
        const StepResult result = solids.run(spec.name, kLeaveOut, threads);
        left_out += expect_fewer(solids, every, result);
        kept += result.contacts.size();
      }
  }
  EXPECT_GT(kept, 0u);
  EXPECT_GT(left_out, 0u);
}

TEST(ShellNeighbours, ContactsOfShellsWithoutACommonVertexStay) {
  Shape shape = block(ElementType::quad, 2, 2, 1), other = block(ElementType::quad, 2, 2, 1);
  shape.append(other.translate(Vec3(0.3, 0.2, 0.8)), 1);
  const std::vector<Vec3> start = jittered(shape.positions, 0.02, 7);
  std::vector<Vec3> end = start;
  for (std::size_t i = end.size() / 2; i < end.size(); ++i) end[i].z() -= 1.5;
  const Solids solids(shape, start, end, 0.1);
  const StepResult every = solids.run("VolCCD", kKeep), result = solids.run("VolCCD", kLeaveOut);
  EXPECT_GT(result.contacts.size(), 0u);
  EXPECT_EQ(result.contacts, every.contacts);
}

/// A list that covers any motion has the candidates of the step, and no neighbours.
void expect_list_has(const Solids& solids, const char* name, const TestBatch& candidates) {
  const Pipeline pipeline(registry(), registry().pipeline(name));
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  CandidateList list;
  ASSERT_TRUE(list.build(pipeline, solids.step(kLeaveOut), workspace, serial, 0, 1e6));
  const TestBatch& tests = list.tests();
  EXPECT_GE(tests.size(), candidates.size());
  const auto neighbours = [&](FeatureKind kind, const std::vector<FeaturePair>& pairs) {
    return std::ranges::count_if(pairs, [&](FeaturePair pair) {
      return solids.stem_from_one(kind, test_vertices(solids.topology.features(), kind, pair));
    });
  };
  EXPECT_EQ(neighbours(FeatureKind::vf, tests.vf) + neighbours(FeatureKind::ee, tests.ee), 0);
}

/// Where there are feature filters, they are dropped before the narrow phase, and are not candidates.
TEST(ShellNeighbours, AreNeitherTestedNorCandidates) {
  Solids solids = crumpled(1);
  solids.separation = 1.5;
  for (const char* const pipeline : {"VolCCD+", "VolCCD"}) {
    SCOPED_TRACE(pipeline);
    TestBatch every, asked;
    solids.run(pipeline, kKeep, 1, {.candidates = &every});
    solids.run(pipeline, kLeaveOut, 1, {.candidates = &asked});
    const auto left = [&](FeatureKind kind, std::vector<FeaturePair> tests) {
      std::erase_if(tests, [&](FeaturePair pair) {
        return solids.stem_from_one(kind, test_vertices(solids.topology.features(), kind, pair));
      });
      return tests;
    };
    EXPECT_EQ(asked.vf, left(FeatureKind::vf, every.vf));
    EXPECT_EQ(asked.ee, left(FeatureKind::ee, every.ee));
    EXPECT_GT(asked.size(), 0u);
    EXPECT_LT(asked.size(), every.size());
    expect_list_has(solids, pipeline, asked);
    EXPECT_LT(solids.run(pipeline, kLeaveOut).statistics.tests(), solids.run(pipeline, kKeep).statistics.tests());
  }
}

/// The earliest contact is the earliest one that is not left out, even if others are earlier.
TEST(ShellNeighbours, AreNotTheFirstContact) {
  for (const double angle : {3.0, 3.1}) {
    SCOPED_TRACE(angle);
    const Solids solids = book(0.2, angle);
    const StepResult all = solids.run("BruteForce", kLeaveOut);
    ASSERT_GT(all.contacts.size(), 0u);
    const double earliest = all.statistics.earliest_toi;
    EXPECT_LT(solids.run("BruteForce", kKeep).statistics.earliest_toi, earliest);
    const Contact first = *std::ranges::min_element(all.contacts, [](const Contact& x, const Contact& y) {
      return x.toi != y.toi ? x.toi < y.toi : canonical_less(x, y);
    });
    for (const PipelineSpec& spec : certified_pipelines())
      for (const unsigned threads : {1u, 3u}) {
        SCOPED_TRACE(spec.name + " " + std::to_string(threads));
        const StepResult result = solids.run(spec.name, kLeaveOut, threads, {.query = Query::first});
        ASSERT_EQ(result.contacts.size(), 1u);
        EXPECT_EQ(result.contacts.front(), first);
      }
  }
}

TEST(ShellNeighbours, AreRefusedWhereVerticesAreNotThreeByThree) {
  const Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  const Topology topology(shape.mesh());
  ASSERT_NE(topology.mesh().vertex_count() % 3, 0u);
  Motion motion;
  motion.set_linear(shape.positions, shape.positions);
  const Pipeline pipeline(registry(), registry().pipeline("VolCCD"));
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  StepResult result;
  Step step{topology, motion, kAll};
  EXPECT_NO_THROW(pipeline.run(step, workspace, serial, result));
  step.leave_out_shell_neighbours = true;
  EXPECT_THROW(pipeline.run(step, workspace, serial, result), ConfigError);
}

TEST(Statistics, ContactsAtTheStartAreCounted) {
  Statistics sum;
  std::uint64_t at_start = 0, contacts = 0;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Solids solids = crumpled(seed);
    solids.separation = 1.5;
    for (const bool leave_out : {false, true}) {
      const StepResult result = solids.run("VolCCD+", leave_out);
      const auto count = std::ranges::count_if(result.contacts, [](const Contact& c) { return c.at_start; });
      EXPECT_EQ(result.statistics.contacts_at_start, static_cast<std::uint64_t>(count));
      sum += result.statistics;
      at_start += static_cast<std::uint64_t>(count);
      contacts += result.contacts.size();
    }
  }
  EXPECT_GT(at_start, 0u);
  EXPECT_LT(at_start, contacts);
  EXPECT_EQ(sum.contacts_at_start, at_start);
  EXPECT_EQ(sum.contacts, contacts);
}

}  // namespace
}  // namespace volccd
