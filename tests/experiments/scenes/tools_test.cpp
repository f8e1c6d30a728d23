// Rigid tools as elements: their shapes, and that bodies of the scenes meet them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/experiments/scenes/geometry/tools.hpp>
#include <volccd/experiments/scenes/simulated/crash.hpp>
#include <volccd/experiments/scenes/simulated/liver.hpp>
#include <volccd/experiments/scenes/simulated/octopi.hpp>
#include <volccd/experiments/scenes/simulated/simulated_scene.hpp>

#include "support/one_step.hpp"

namespace volccd {
namespace {

using simulation::Model;
using simulation::Simulation;

/// All volumes positive, each face of at most two tetrahedra; returns the volume.
double expect_conforming(const Shape& shape) {
  std::map<std::array<Index, 3>, int> faces;
  double volume = 0;
  for (const ElementSpec& e : shape.elements) {
    const auto x = [&](std::size_t i) { return shape.positions[e.vertices[i]]; };
    const double six = (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0));
    EXPECT_GT(six, 0);
    volume += six / 6;
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::vector<Index> face = e.vertices;
      face.erase(face.begin() + static_cast<std::ptrdiff_t>(skip));
      std::ranges::sort(face);
      const int uses = ++faces[{face[0], face[1], face[2]}];
      EXPECT_LE(uses, 2);
    }
  }
  // One ball: V - E + F = 2 on its surface, where 3 F = 2 E.
  std::vector<Index> vertices;
  std::size_t outer = 0;
  for (const auto& [face, uses] : faces)
    if (uses == 1) {
      ++outer;
      vertices.insert(vertices.end(), face.begin(), face.end());
    }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  EXPECT_EQ(2 * vertices.size(), outer + 4);
  return volume;
}

TEST(Tools, AFunnelHasSixWallsThatFaceTheOrigin) {
  const FunnelShape shape{.depth = 0.3, .slope = 0.7, .thickness = 0.01, .rings = 5};
  const Shape funnel_of_it = funnel(shape);
  EXPECT_EQ(funnel_of_it.elements.size(), static_cast<std::size_t>(shape.elements()));
  const double inner_radius = 0.3 / std::sin(0.7), base = 2 * std::sqrt(3.0) * inner_radius * inner_radius;
  EXPECT_NEAR(expect_conforming(funnel_of_it), base * 0.01 / std::cos(0.7), 1e-9);
  std::size_t inside = 0;
  for (const Vec3& p : funnel_of_it.positions) {
    double min = 1;
    for (int i = 0; i < 6; ++i) {
      const double a = i * M_PI / 3;
      min = std::min(min, Vec3(std::sin(0.7) * std::cos(a), std::sin(0.7) * std::sin(a), std::cos(0.7)).dot(p));
    }
    EXPECT_TRUE(std::abs(min + 0.3) < 1e-12 || std::abs(min + 0.31) < 1e-12) << min;
    inside += min > -0.305;
    EXPECT_LE(p.z(), 1e-12);
  }
  EXPECT_EQ(2 * inside, funnel_of_it.positions.size());
  EXPECT_THROW(funnel({.slope = 1.6}), ConfigError);
  EXPECT_THROW(funnel({.rings = 0}), ConfigError);
}

TEST(Tools, AKnifeGrowsFromItsEdge) {
  const KnifeShape shape{.width = 0.2, .height = 0.1, .thickness = 0.004, .bevel = 0.02, .along = 7, .down = 4};
  const Shape knife_of_it = knife(shape);
  EXPECT_EQ(knife_of_it.elements.size(), static_cast<std::size_t>(shape.elements()));
  EXPECT_NEAR(expect_conforming(knife_of_it), 0.2 * 0.004 * (0.02 / 2 + 0.08), 1e-12);
  for (const Vec3& p : knife_of_it.positions) EXPECT_NEAR(std::abs(p.y()), 0.002 * std::min(1.0, -p.z() / 0.02), 1e-12);
  EXPECT_THROW(knife({.height = 0.1, .bevel = 0.1}), ConfigError);
  EXPECT_THROW(knife({.down = 1}), ConfigError);
}

std::int32_t object_of(const Simulation& s, Index v) {
  return s.topology().mesh().object(s.topology().features().vertex_elements(v)[0]);
}

/// Contacts of the last query between the part and others.
std::size_t contacts_with(const Simulation& s, std::int32_t part) {
  const auto query = s.last_query();
  const Motion motion = Motion::linear(query->start, query->end);
  const StepResult result = test::run_step({s.topology(), motion, test::kAllObjects, query->separation});
  std::size_t count = 0;
  for (const Contact& c : result.contacts)
    count += (object_of(s, c.vertices[0]) == part) != (object_of(s, c.vertices[3]) == part);
  return count;
}

/// The scene's simulation of a model on one and on three threads, up to a time, with equal bits.
Simulation simulated(const SimulatedScene& scene, const Model& model, double time, Executor& one) {
  const auto three = make_executor(3);
  Simulation a(model, scene.options, one), b(model, scene.options, *three);
  a.advance_to(time);
  b.advance_to(time);
  EXPECT_EQ(a.positions().size(), b.positions().size());
  EXPECT_EQ(std::memcmp(a.positions().data(), b.positions().data(), a.positions().size_bytes()), 0);
  return a;
}

void expect_still(const Simulation& s, const Model& model, std::int32_t part, const Vec3& by = Vec3::Zero()) {
  std::size_t count = 0;
  for (Index v = 0; v < model.positions.size(); ++v)
    if (object_of(s, v) == part) {
      ASSERT_EQ(s.positions()[v], model.positions[v] + by);
      ++count;
    }
  EXPECT_GT(count, 10u);
}

TEST(ScenesWithTools, TheFunnelIsInTheQueriesAndCarriesTheOctopi) {
  const SimulatedScene& scene = *find_simulated_scene("octopi");
  const Model model = octopi_model(1'500);
  SerialExecutor one;
  Simulation s = simulated(scene, model, 0.3, one);
  s.drain_counts();
  for (double time = 0.325; time < 0.41; time += 0.025) {
    const Vec3 before = s.ledger().impulse;
    s.advance_to(time);
    EXPECT_GT(contacts_with(s, 3), 0u) << time;
    EXPECT_EQ(s.drain_counts().unresolved, 0u);
    double mass = 0;
    for (Index v = 0; v < model.positions.size(); ++v) mass += object_of(s, v) < 3 ? s.mass(v) : 0;
    EXPECT_GT((s.ledger().impulse - before).z(), -0.8 * 9.81 * mass * 0.025) << "it carries a part of the weight";
  }
  expect_still(s, model, 3);
  const simulation::Ledger& l = s.ledger();
  EXPECT_LT(std::abs(l.balance_error()), 0.005 * (l.initial + l.external));
  double lowest = 0;
  for (const Index v : model.fixed) lowest = std::min(lowest, model.positions[v].z());
  for (const Vec3& p : s.positions()) EXPECT_GE(p.z(), lowest) << "nothing falls through";
}

TEST(ScenesWithTools, TheWallStopsTheCar) {
  const SimulatedScene& scene = *find_simulated_scene("crash");
  const Model model = crash_model(2'000);
  SerialExecutor one;
  Simulation s = simulated(scene, model, 0.0015, one);
  const simulation::Ledger& l = s.ledger();
  const Vec3 first = l.momentum - l.impulse;
  for (double time = 0.002; time < 0.0041; time += 0.0005) {
    const double before = l.impulse.x();
    s.advance_to(time);
    EXPECT_GT(l.impulse.x(), before) << "only the wall pushes";
  }
  EXPECT_GT(s.drain_counts().inter, 0u);
  EXPECT_LT((l.momentum - l.impulse - first).norm(), 1e-9 * l.momentum.norm());
  EXPECT_LT(std::abs(l.balance_error()), 0.002 * l.initial);
  expect_still(s, model, 18);
  double wall = -10;
  for (const Index v : model.fixed) wall = std::max(wall, model.positions[v].x());
  for (const Vec3& p : s.positions()) EXPECT_GT(p.x(), wall - 1e-9) << "nothing passes through";
}

TEST(ScenesWithTools, TheScalpelMovesAsPrescribedInTheCut) {
  const SimulatedScene& scene = *find_simulated_scene("liver");
  const Model model = liver_model(500);
  ASSERT_EQ(model.guides.size(), 1u);
  SerialExecutor one;
  Simulation s = simulated(scene, model, 0.75, one);
  for (double time = 0.8; time < 0.96; time += 0.05) {
    s.drain_counts();
    s.advance_to(time);
    const simulation::SimulationCounts counts = s.drain_counts();
    EXPECT_GT(counts.inter, 0u) << time << ": between liver and scalpel";
    EXPECT_EQ(counts.unresolved, 0u);
    expect_still(s, model, 1, model.guides[0].displacement(time));
  }
  EXPECT_GT(contacts_with(s, 1), 0u);
  const simulation::Ledger& l = s.ledger();
  EXPECT_LT((l.momentum - l.impulse).norm(), 1e-10);
  EXPECT_LT(std::abs(l.balance_error()), 0.01 * l.external);
}

}  // namespace
}  // namespace volccd
