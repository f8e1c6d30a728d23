// The bounds on which candidate lists rest hold as written, and a list follows edits.
#include <volccd/pipelines/lists/candidate_list.hpp>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/pipelines/step_runner.hpp>

#include "pipelines/lists/listed_steps.hpp"

namespace volccd::test {
namespace {

#if LDBL_MANT_DIG == 113  // AArch64
using Quad = long double;
#else
__extension__ using Quad = __float128;
#endif

/// The distance of control points from the prediction, to 113 bits.
Quad square_distance(const Motion& motion, const Motion& lines, Index v, int i, double at) {
  Quad sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Quad from = lines.point(v, 0)[k], to = lines.point(v, 1)[k],
               d = Quad(motion.point(v, i)[k]) - (from + Quad(at) * (to - from));
    sum += d * d;
  }
  return sum;
}

/// Vertices of a tetrahedron and their features.
Topology tetrahedron() { return Topology(block(ElementType::tetrahedron, 1, 1, 1).mesh()); }

TEST(PredictedMotion, DistanceIsAnUpperBound) {
  const Topology topology = tetrahedron();
  Random random(3);
  int tight = 0;
  for (int round = 0; round < 4000; ++round) {
    const double size = std::exp2(random.uniform(-60, 60)), offset = random.below(2) * 1e8 * size;
    const Index n = topology.mesh().vertex_count();
    std::vector<Vec3> x0(n), x1(n), q0(n), q1(n);
    for (Index v = 0; v < n; ++v) {
      x0[v] = offset * Vec3(1, -1, 1) + random_vector(random, size);
      x1[v] = x0[v] + random_vector(random, size);
    }
    detail::PredictedMotion predicted;
    ASSERT_TRUE(predicted.set(Motion::linear(x0, x1), random.uniform(0, 50), topology.features()));
    const detail::PredictedMotion::Interval at{random.uniform(0, 1), random.uniform(0, 1)};
    const double away = random.below(3) == 0 ? 0 : size * std::exp2(random.uniform(-60, 0));
    for (Index v = 0; v < n; ++v) {
      q0[v] = predicted.lines().position(v, at.begin) + random_vector(random, away);
      q1[v] = predicted.lines().position(v, at.end) + random_vector(random, away);
    }
    const Motion motion = Motion::linear(q0, q1);
    const double bound = predicted.distance(motion, topology.features(), at, serial_executor());
    Quad worst = 0;
    for (Index v = 0; v < n; ++v)
      for (int i = 0; i < 2; ++i)
        worst = std::max(worst, square_distance(motion, predicted.lines(), v, i, i == 0 ? at.begin : at.end));
    EXPECT_LE(worst, Quad(bound) * Quad(bound));
    tight += Quad(bound) * Quad(bound) < Quad(1.0001) * worst ? 1 : 0;
  }
  EXPECT_GT(tight, 500);
}

/// A motion that rests is at the start of the prediction, and all of its way from the end.
TEST(PredictedMotion, ControlPointsAreComparedAtTheirTimes) {
  const Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  const Topology topology(shape.mesh());
  std::vector<Vec3> moved = shape.positions;
  for (std::size_t v = 0; v < 8; ++v) moved[v].y() += 1;  // not the last ones, which are compared one by one
  detail::PredictedMotion predicted;
  ASSERT_TRUE(predicted.set(Motion::linear(shape.positions, moved), 1, topology.features()));
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const auto distance = [&](double begin, double end) {
    return predicted.distance(rest, topology.features(), {begin, end}, serial_executor());
  };
  EXPECT_LT(distance(0, 0), 1e-12);
  EXPECT_NEAR(distance(0, 1), 1, 1e-12);
  EXPECT_NEAR(distance(1, 0), 1, 1e-12);
  EXPECT_NEAR(distance(0.25, 0.5), 0.5, 1e-12);
}

/// A vertex that no element uses may be anywhere.
TEST(PredictedMotion, VerticesWithoutElementsDoNotCount) {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.positions.push_back(Vec3(1, 2, 3));
  const Topology topology(shape.mesh());
  detail::PredictedMotion predicted;
  std::vector<Vec3> moved = shape.positions;
  ASSERT_TRUE(predicted.set(Motion::linear(shape.positions, moved), 4, topology.features()));
  moved.back() = Vec3(1e300, 0, 0);
  EXPECT_LT(predicted.distance(Motion::linear(moved, moved), topology.features(), {0, 1}, serial_executor()), 1e-12);
  moved.front() += Vec3(0.5, 0, 0);
  EXPECT_GE(predicted.distance(Motion::linear(moved, moved), topology.features(), {0, 1}, serial_executor()), 0.5);
}

/// The separation of a list is at least s + 2 b without rounding, and a budget is used to the last bit.
TEST(CandidateList, SeparationIsRoundedUp) {
  Random random(5);
  for (int round = 0; round < 10000; ++round) {
    const double s = std::exp2(random.uniform(-80, 0)), b = std::exp2(random.uniform(-80, 0));
    EXPECT_GE(Quad(CandidateList::separation(s, b)), Quad(s) + 2 * Quad(b));
    EXPECT_LE(CandidateList::separation(s, b), (s + 2 * b) * (1 + 1e-15));
  }
}

/// Two sheets that rest s + 2 b apart, and approach by b each: every vertex uses its budget up, and touches.
TEST(CandidateList, CoversMotionsThatUseUpTheBudget) {
  const double s = 0.25, b = 0.125;
  Shape shape, other = block(ElementType::quad, 2, 2, 1);
  shape.append(block(ElementType::quad, 2, 2, 1), 1);
  shape.append(other.translate(Vec3(0.25, 0.25, s + 2 * b)), 2);
  const Topology topology(shape.mesh());
  std::vector<Vec3> near = shape.positions;
  for (Vec3& p : near) p.z() += p.z() > 0 ? -b : b;
  const auto runner = [&](double budget) {
    return StepRunner(Pipeline(registry(), registry().pipeline("VolCCD+")),
                      {.separation = s, .lists = {ListConfig::Use::always, budget, 0}});
  };
  const Motion rest = Motion::linear(shape.positions, shape.positions),
               approach = Motion::linear(shape.positions, near);
  const double slack = 1e-15;
  for (const auto& [budget, reused] :
       {std::pair{b * (1 + 16 * slack) + 32 * slack, true}, std::pair{b * (1 - slack), false}}) {
    StepRunner listed = runner(budget), fresh = runner(budget);
    EXPECT_EQ(listed.run(topology, rest).contacts.size(), 0u);
    expect_equal(fresh.run(topology, approach), listed.run(topology, approach), "budget " + std::to_string(budget));
    EXPECT_EQ(listed.result().statistics.reused_steps, reused ? 1u : 0u);
    EXPECT_EQ(listed.result().statistics.list_budget, reused ? budget : 0);
    EXPECT_GT(listed.result().contacts.size(), 0u);
  }
}

/// A list is for steps with at most its separation, whoever uses it.
TEST(CandidateList, IsNotForAGreaterSeparation) {
  const double s = 0.1;
  const Shape shape = two_bodies(block(ElementType::tetrahedron, 1, 1, 1));
  const Topology topology(shape.mesh());
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const ObjectFilter filter;
  const Pipeline pipeline(registry(), registry().pipeline("VolCCD+"));
  Workspace workspace = pipeline.make_workspace();
  const auto step = [&](double separation) { return Step{topology, rest, filter, separation}; };
  CandidateList list;
  ASSERT_TRUE(list.build(pipeline, step(s), workspace, serial_executor(), 0, 0.05));
  EXPECT_TRUE(list.covers(pipeline, step(s), serial_executor()));
  EXPECT_TRUE(list.covers(pipeline, step(s / 2), serial_executor()));
  EXPECT_FALSE(list.covers(pipeline, step(std::nextafter(s, 1)), serial_executor()));
  EXPECT_TRUE(list.empty());
}

/// Three sheets at rest: two within the separation, and one that approaches them. Steps near the prediction do not test
/// the third one.
TEST(CandidateList, HasInnerListsForStepsNearThePrediction) {
  const double s = 0.25, b = 0.125;
  Shape shape = block(ElementType::quad, 2, 2, 1), second = shape, third = shape;
  for (ElementSpec& e : second.elements) e.id += 1000;
  for (ElementSpec& e : third.elements) e.id += 2000;
  const std::size_t count = shape.positions.size();
  shape.append(second.translate(Vec3(0.25, 0.25, -s / 2)), 2);
  shape.append(third.translate(Vec3(0.125, 0.25, s + b)), 3);
  const Topology topology(shape.mesh());
  const auto lowered = [&](double by) {
    std::vector<Vec3> ends = shape.positions;
    for (std::size_t v = 2 * count; v < ends.size(); ++v) ends[v].z() -= by;
    return Motion::linear(shape.positions, ends);
  };
  const auto runner = [&](const ListConfig& lists) {
    return StepRunner(Pipeline(registry(), registry().pipeline("VolCCD+")), {.separation = s, .lists = lists});
  };
  StepRunner fresh = runner({}), listed = runner({ListConfig::Use::always, b, 0});
  // The budgets are b, b/8 and b/64. The third step nearly uses up the first one.
  std::vector<std::size_t> contacts, tests;
  for (const double by : {0.0, b / 16, b * 0.999, b / 16}) {
    expect_equal(fresh.run(topology, lowered(by)), listed.run(topology, lowered(by)), std::to_string(by));
    contacts.push_back(listed.result().contacts.size());
    tests.push_back(listed.result().statistics.list_tests);
    EXPECT_EQ(listed.result().statistics.list_steps, tests.size() == 1 ? 1u : 0u);
  }
  EXPECT_GT(contacts[0], 0u);
  EXPECT_EQ(contacts[2], contacts[0]);
  EXPECT_LE(tests[0], tests[1]);
  EXPECT_LT(tests[1], tests[2]);
  EXPECT_EQ(tests[3], tests[1]);
  // Both sides approach.
  std::vector<Vec3> near = shape.positions;
  for (std::size_t v = 0; v < near.size(); ++v) near[v].z() += (v < 2 * count ? 0.6 : -0.6) * b;
  const Motion approach = Motion::linear(shape.positions, near);
  expect_equal(fresh.run(topology, approach), listed.run(topology, approach), "approach");
  EXPECT_EQ(listed.result().statistics.reused_steps, 1u);
  EXPECT_GT(listed.result().contacts.size(), contacts[0]);
}

/// Two sheets that rest at half of the separation, with a list. Edits remove elements of the upper one, whose last
/// vertices are above the lower one.
class RestingSheets {
 public:
  RestingSheets() {
    Shape shape = block(ElementType::quad, 2, 2, 1), other = shape;
    for (ElementSpec& e : other.elements) e.id += 1000;
    lower_ = static_cast<Index>(shape.elements.size());
    shape.append(other.translate(Vec3(-0.25, -0.25, 0.125)), 2);
    topology_.emplace(shape.mesh());
    rest_ = Motion::linear(shape.positions, shape.positions);
  }

  /// Removes elements of the upper sheet from the `first` on.
  void remove_upper(Index first) {
    TopologyEdit edit;
    for (Index o = lower_ + first; o < topology_->mesh().element_slots(); ++o) {
      removed_.push_back(topology_->mesh().spec(o));
      edit.removed.push_back(o);
    }
    topology_->apply(edit);
  }
  void add_again() { topology_->apply({{}, {}, std::exchange(removed_, {})}); }

  /// Compares with a run without a list. Returns the number of contacts.
  std::size_t compare(const std::string& what) {
    expect_equal(fresh_.run(*topology_, rest_), listed_.run(*topology_, rest_), what);
    return fresh_.result().contacts.size();
  }
  /// How the last step used a list.
  Uses uses() const {
    const Statistics& statistics = listed_.result().statistics;
    return {statistics.reused_steps, statistics.refreshed_steps};
  }

 private:
  static StepRunner runner(const ListConfig& lists) {
    return StepRunner(Pipeline(registry(), registry().pipeline("VolCCD+")), {.separation = 0.25, .lists = lists});
  }

  Index lower_ = 0;
  std::optional<Topology> topology_;
  Motion rest_;
  std::vector<ElementSpec> removed_;
  StepRunner fresh_ = runner({}), listed_ = runner({ListConfig::Use::always, 0.05, 0});
};

/// A vertex that has lost its elements has no contact, although it is still where it was.
TEST(CandidateList, HasNoTestsOfRemovedVertices) {
  RestingSheets sheets;
  const std::size_t whole = sheets.compare("whole");
  sheets.remove_upper(1);
  const std::size_t part = sheets.compare("removed");
  EXPECT_EQ(sheets.uses().reused, 1u);
  EXPECT_GT(part, 0u);
  EXPECT_LT(part, whole);
}

/// Elements that come back, on vertices that were there all the time.
TEST(CandidateList, HasTestsOfElementsThatComeBack) {
  RestingSheets sheets;
  sheets.remove_upper(1);
  sheets.compare("removed");
  const std::size_t part = sheets.compare("removed, with the list");
  EXPECT_EQ(sheets.uses().reused, 1u);
  sheets.add_again();
  const std::size_t whole = sheets.compare("added again");
  EXPECT_EQ(sheets.uses().refreshed, 1u);
  EXPECT_GT(whole, part);
}

/// All elements belong to one object, so that a filter asks for no contact, until an edit changes that of an inner one:
/// all its features have other elements, too, and are neither removed nor added.
TEST(CandidateList, HasTestsOfAnInnerElementThatChangesItsObject) {
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
  Topology topology(shape.mesh());
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const auto runner = [&](const ListConfig& lists) {
    return StepRunner(Pipeline(registry(), registry().pipeline("VolCCD+")),
                      {.separation = 0.75, .filter = ObjectFilter(PairScope::inter), .lists = lists});
  };
  StepRunner fresh = runner({}), listed = runner({ListConfig::Use::always, 0.05, 0});
  EXPECT_TRUE(listed.run(topology, rest).contacts.empty());
  Index inner = 0;
  const auto is_inner = [&](Index o) {
    return std::ranges::all_of(topology.features().element_triangles(o),
                               [&](Index f) { return topology.features().triangle_elements(f).size() == 2; });
  };
  while (!is_inner(inner)) ++inner;
  ElementSpec changed = topology.mesh().spec(inner);
  changed.object = 2;
  EXPECT_TRUE(topology.apply({{inner}, {}, {changed}}).features.added_vertices.empty());
  expect_equal(fresh.run(topology, rest), listed.run(topology, rest), "changed");
  EXPECT_GT(listed.result().contacts.size(), 0u);
  EXPECT_EQ(listed.result().statistics.refreshed_steps, 1u);
}

}  // namespace
}  // namespace volccd::test
