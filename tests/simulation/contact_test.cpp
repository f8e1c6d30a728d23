// Contacts of simulated bodies: momentum, energy, friction, and that no body passes through another.
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/simulation/contact/contact_response.hpp>
#include "simulation_models.hpp"
#include "support/one_step.hpp"

namespace volccd::simulation {
namespace {

/// Number of pairs of non-adjacent elements that overlap, decided exactly by code that the response does not use.
std::size_t overlaps(const Simulation& s) {
  const Motion motion = Motion::linear(s.positions(), s.positions());
  return test::run_step({s.topology(), motion, test::kAllObjects}, {.initial_overlaps = true}).initial_overlaps.size();
}

/// Fraction of the energy by which the balance may be wrong. The work of bulk viscosity is computed with the velocity
/// before the substep, and is too large if an impact reverses velocities within the substep.
double booking(double restitution) { return restitution > 0 ? 0.35 : 0.03; }

TEST(ContactWall, BounceKeepsEnergy) {
  for (double restitution : {0.0, 1.0}) {
    Model model = blocks({{.nx = 3, .ny = 3, .nz = 4, .at = Vec3(0, 0, 0.01), .velocity = Vec3(0, 0, -1)}});
    model.walls.push_back({});
    model.bodies[0].material.restitution = restitution;
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    const Ledger before = s.ledger();
    s.advance_to(0.08);
    const Ledger& after = s.ledger();
    EXPECT_GT(after.momentum.z(), -0.7 * before.momentum.z());
    EXPECT_LT(std::abs(after.balance_error()), booking(restitution) * before.initial);
    EXPECT_GT(after.kinetic + after.elastic, (restitution > 0 ? 0.9 : 0.6) * before.initial);
    EXPECT_LT((after.momentum - before.momentum - after.impulse).norm(), 1e-11 * before.momentum.norm());
    for (const Vec3& x : s.positions()) EXPECT_GT(x.z(), -1e-9);
  }
}

TEST(ContactBlocks, ImpactKeepsMomentumAndBalancesEnergy) {
  for (double restitution : {0.0, 1.0}) {
    Model model = blocks({{.nx = 3, .velocity = Vec3(2, 0, 0)}, {.nx = 3, .at = Vec3(0.31, 0.03, -0.02)}});
    for (Body& body : model.bodies) body.material.restitution = restitution;
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    const Ledger before = s.ledger();
    s.advance_to(0.06);
    const Ledger& after = s.ledger();
    const SimulationCounts counts = s.drain_counts();
    EXPECT_GT(counts.inter, 0u);
    EXPECT_EQ(counts.unresolved, 0u);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
    EXPECT_LT(std::abs(after.balance_error()), booking(restitution) * before.initial);
    EXPECT_GT(mean(s, s.velocities(), 1).x(), 1.2);
    EXPECT_LT(mean(s, s.velocities(), 0).x(), 0.8);
    EXPECT_EQ(overlaps(s), 0u);
  }
}

TEST(ContactFastPlate, NothingPassesThrough) {
  // In a substep, the stiff block moves by more than the thickness of the soft plate.
  Model model =
      blocks({{ElementType::tetrahedron, 2, 2, 2, Vec3(0.1, 0.1, 0.1), Vec3(-0.25, 0.05, 0.05), Vec3(40, 3, 1)},
              {ElementType::tetrahedron, 1, 3, 3, Vec3(0.004, 0.1, 0.1)}});
  model.bodies[0].material.youngs_modulus = 1e8;
  model.bodies[1].material.youngs_modulus = 1e4;
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  for (double time = 5e-4; time < 0.008; time += 5e-4) {
    s.advance_to(time);
    ASSERT_EQ(overlaps(s), 0u) << "at " << time;
  }
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GT(40 * 0.008 / static_cast<double>(counts.substeps), 0.004 / 2);
  EXPECT_GT(counts.inter, 0u);
  EXPECT_EQ(counts.unresolved, 0u);
  EXPECT_LT(mean(s, s.positions(), 0).x(), mean(s, s.positions(), 1).x());
}

TEST(ContactSlope, SticksBelowTheAngleAndSlidesAboveIt) {
  const double mu = 0.5, g = 9.81;
  for (double slope : {0.25, 0.8}) {
    Model model = blocks({{}});
    model.bodies[0].material.youngs_modulus = 1e7;
    model.walls.push_back({Vec3::Zero(), Vec3::UnitZ(), mu});
    const double angle = std::atan(slope), t = 0.2;
    model.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    const double at = mean(s, s.positions(), 0).x();
    s.advance_to(t);
    const double moved = mean(s, s.positions(), 0).x() - at;
    const double expected = slope < mu ? 0 : g * (std::sin(angle) - mu * std::cos(angle)) * t * t / 2;
    EXPECT_NEAR(moved, expected, 0.05 * expected + 5e-4) << slope;
    EXPECT_TRUE(slope < mu || s.ledger().friction > 0);
    EXPECT_LT(std::abs(s.ledger().balance_error()), 0.02 * s.ledger().external);
  }
}

TEST(ContactBlockOnBlock, SlidesWithTheSmallerFriction) {
  // A rigid block on a fixed rigid table. The contacts come from the pipeline, not from a wall.
  const double g = 9.81, t = 0.1;
  Body block_body{"block", soft()}, table{"table", soft()};
  block_body.rigid = table.rigid = true;
  block_body.material.friction = 0.2;
  table.material.friction = 0.6;
  Model model = blocks({{.at = Vec3(0.211, 0.207, 1e-4), .body = block_body},
                        {.nx = 1, .ny = 1, .nz = 1, .size = Vec3(1, 1, 0.1), .at = Vec3(0, 0, -0.1), .body = table}});
  model.fixed.push_back(model.mesh.vertex_count() - 1);
  model.gravity = g * Vec3(0.6, 0, -0.8);
  SimulationOptions options;
  options.max_step = 5e-4;
  options.separation = 1e-4;
  SerialExecutor executor;
  Simulation s(model, options, executor);
  const double at = mean(s, s.positions(), 0).x();
  s.advance_to(t);
  const double expected = g * (0.6 - 0.2 * 0.8) * t * t / 2;
  EXPECT_NEAR(mean(s, s.positions(), 0).x() - at, expected, 0.03 * expected);
  EXPECT_EQ(overlaps(s), 0u);
}

TEST(ContactAtStart, TouchingAndOverlappingBlocksPartWithoutSticking) {
  for (double gap : {0.0, 2e-4, -2e-4, -0.03}) {
    Model model = blocks({{.velocity = Vec3(-1, 0, 0)}, {.at = Vec3(0.2 + gap, 0, 0), .velocity = Vec3(1, 0, 0)}});
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    s.advance_to(0.02 + std::abs(gap) / 2);
    EXPECT_NEAR(mean(s, s.velocities(), 1).x(), 1, 0.05) << gap;
    EXPECT_EQ(overlaps(s), 0u) << gap;
  }
}

TEST(ContactAtStart, WhatTouchesIsStopped) {
  // Conforming faces touch and are pressed together, so that only the positions of the elements give a direction.
  for (double lateral : {0.0, 0.03}) {
    Model model =
        blocks({{.velocity = Vec3(0.5, 0, 0)}, {.at = Vec3(0.2, lateral, lateral), .velocity = Vec3(-0.5, 0, 0)}});
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    for (double time = 0.005; time < 0.06; time += 0.005) {
      s.advance_to(time);
      EXPECT_LT(mean(s, s.positions(), 0).x(), 0.1 + 0.01);
      EXPECT_GT(mean(s, s.positions(), 1).x(), 0.3 - 0.01);
    }
    EXPECT_LT(mean(s, s.velocities(), 0).x(), -0.1);
    EXPECT_GT(mean(s, s.velocities(), 1).x(), 0.1);
  }
}

TEST(ContactAtStart, FacesInTouchGetTheirNormalFromTheElements) {
  for (double lateral : {0.0, 0.03}) {
    const Model model = blocks({{}, {.at = Vec3(0.2, lateral, lateral)}});
    const Topology topology(model.mesh);
    SerialExecutor executor;
    ContactDetection detection(topology, std::vector<double>(topology.mesh().element_slots(), 0.0), model.positions,
                               {"VolCCD+", ContactFeatures::all, true, {}, 1e-3}, executor);
    std::vector<FoundContact> found;
    detection.find(model.positions, model.positions, found);
    std::size_t resisted = 0;
    for (const FoundContact& c : found) {
      if (c.verdict != ContactVerdict::resist) continue;
      EXPECT_TRUE(c.at_start);
      EXPECT_NEAR(c.normal.x(), c.object_a == 0 ? -1 : 1, 1e-9);
      ++resisted;
    }
    EXPECT_GE(resisted, 9u) << "of " << found.size();
  }
}

/// Two jaws with a common edge close on the tip of a needle near that edge. Both contacts move the same heavy vertices,
/// in opposite directions, so that the passes do not separate them and vertices are held in many substeps.
/// The needle is squeezed to a sliver that deforms faster than a wave crosses it.
TEST(ContactHeld, WhatIsHeldGainsNoEnergy) {
  Shape jaws, needle;
  jaws.positions = {Vec3(0, 0, 0),          Vec3(0, 0.1, 0),         Vec3(0.1, 0.05, 0.002),
                    Vec3(0.05, 0.05, 0.05), Vec3(0.1, 0.05, -0.002), Vec3(0.05, 0.05, -0.05)};
  jaws.elements = {{.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}},
                   {.type = ElementType::tetrahedron, .vertices = {0, 4, 1, 5}, .id = 1}};
  needle.elements = {{.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}}};
  for (const auto& [tip, speed] : {std::pair(0.003, 1.0), std::pair(0.0033, 0.99), std::pair(0.0029, 1.01)}) {
    needle.positions = {Vec3(tip, 0.05, 0), Vec3(0.15, 0.049, 0), Vec3(0.15, 0.051, 0.0005), Vec3(0.15, 0.05, -0.0005)};
    Shape all;
    all.append(jaws, 0).append(needle, 1);
    Model model;
    model.mesh = all.mesh();
    model.positions = all.positions;
    model.velocities.assign(all.positions.size(), Vec3::Zero());
    for (const Index v : {2, 3}) model.velocities[v] = Vec3(0, 0, -speed);
    for (const Index v : {4, 5}) model.velocities[v] = Vec3(0, 0, speed);
    model.bodies = {{"jaws", soft()}, {"needle", soft()}};
    for (const bool fixed : {false, true}) {
      SCOPED_TRACE(testing::Message() << tip << ' ' << speed << ' ' << fixed);
      if (fixed) model.fixed = {0, 1};
      SerialExecutor executor;
      Simulation s(model, {}, executor);
      const Ledger before = s.ledger();
      for (int part = 1; part <= 40; ++part) {
        s.advance_to(1e-4 * part);
        ASSERT_LT(s.ledger().kinetic + s.ledger().elastic, 2 * before.initial) << part;
      }
      const SimulationCounts counts = s.drain_counts();
      const Ledger& after = s.ledger();
      EXPECT_GT(counts.held, 50u);
      EXPECT_EQ(counts.unresolved, 0u);
      EXPECT_GT(after.contact, 0);
      EXPECT_LT(after.kinetic + after.elastic + after.numerical, before.initial);
      EXPECT_LT((after.momentum - after.impulse).norm(), 1e-12);
      EXPECT_EQ(overlaps(s), 0u);
    }
  }
}

TEST(ContactFeatureSets, InteriorFeaturesCollideOnlyWhereAskedFor) {
  // A small block inside an element of a large one, away from its boundary, moves towards the next element.
  const Model model = blocks({{.nx = 4, .ny = 3, .nz = 3},
                              {.nx = 1,
                               .ny = 1,
                               .nz = 1,
                               .size = Vec3(0.03, 0.03, 0.03),
                               .at = Vec3(0.14, 0.13, 0.15),
                               .velocity = Vec3(5, 0, 0)}});
  SerialExecutor executor;
  SimulationOptions boundary;
  boundary.features = ContactFeatures::boundary;
  Simulation all(model, {}, executor), outside(model, boundary, executor);
  all.advance_to(0.02);
  outside.advance_to(0.02);
  const SimulationCounts a = all.drain_counts(), b = outside.drain_counts();
  EXPECT_GT(a.inter, 0u);
  EXPECT_EQ(b.inter, 0u);
  EXPECT_GT(b.ignored, 0u);
  EXPECT_LT(mean(all, all.positions(), 1).x(), 0.2);
  EXPECT_NEAR(mean(outside, outside.positions(), 1).x(), 0.155 + 5 * 0.02, 1e-9);
}

TEST(ContactAdjacent, TurningOverIsResistedAndTurningBackIsNot) {
  Shape shape;
  shape.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, 0.3, 0.5)};
  shape.elements.push_back({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}});
  const Topology topology(shape.mesh());
  std::vector<Vec3> over = shape.positions;
  over[3].z() = -0.5;
  SerialExecutor executor;
  const auto verdict = [&](bool adjacent, std::span<const Vec3> x0, std::span<const Vec3> x1) {
    ContactDetection detection(topology, std::vector<double>(1, 0.0), shape.positions,
                               {"VolCCD+", ContactFeatures::all, adjacent, {}, 0.01}, executor);
    std::vector<FoundContact> found;
    detection.find(x0, x1, found);
    EXPECT_EQ(found.size(), 1u);
    EXPECT_EQ(found.at(0).contact_class, ContactClass::adjacent);
    return found.at(0).verdict;
  };
  EXPECT_EQ(verdict(true, shape.positions, over), ContactVerdict::resist);
  EXPECT_EQ(verdict(true, over, shape.positions), ContactVerdict::leaving);
  EXPECT_EQ(verdict(false, shape.positions, over), ContactVerdict::ignore);
}

TEST(ContactShells, SheetIsHeldByItsThickness) {
  // A sheet of triangles falls onto a fixed block. The prisms of the sheet touch it at half the thickness above.
  Body sheet{"sheet", soft(), 0.004};
  Model model = blocks({{.size = Vec3(0.12, 0.12, 0.1), .at = Vec3(0.08, 0.07, -0.21)},
                        {ElementType::triangle, 4, 4, 1, Vec3(0.1, 0.1, 1), Vec3(0, 0, 0), Vec3(0, 0, -3), sheet}});
  for (Index v = 0; v < 27; ++v) model.fixed.push_back(v);
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  s.advance_to(0.01);
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GT(counts.inter, 0u);
  EXPECT_EQ(counts.unresolved, 0u);
  // The vertex above the middle of the block.
  double lowest = 1;
  for (std::size_t v = 27; v < s.positions().size(); ++v)
    if (std::abs(model.positions[v].x() - 0.2) < 0.01 && std::abs(model.positions[v].y() - 0.2) < 0.01)
      lowest = std::min(lowest, s.positions()[v].z());
  EXPECT_GT(lowest, -0.01 + 0.0019);
  EXPECT_LT(lowest, 0.05);
  EXPECT_LT(std::abs(s.ledger().balance_error()), 0.05 * s.ledger().initial);
}

}  // namespace
}  // namespace volccd::simulation
