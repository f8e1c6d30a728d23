// The time loop keeps the conserved quantities, and gives the same bits when repeated.
#include <cstring>
#include <sstream>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include "simulation_models.hpp"

namespace volccd::simulation {
namespace {

bool same_bits(std::span<const Vec3> a, std::span<const Vec3> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

TEST(SimulationFreeBody, KeepsMomentumAngularMomentumAndEnergy) {
  for (ElementType type : {ElementType::tetrahedron, ElementType::hexahedron}) {
    Model model = blocks({{type, 3, 2, 2}});
    const std::vector<Vec3> noise = jittered(model.velocities, 1, 7);
    for (std::size_t i = 0; i < noise.size(); ++i)
      model.velocities[i] = noise[i] + Vec3(3, 2, 1) + Vec3(1, 5, 2).cross(model.positions[i]);
    SerialExecutor executor;
    Simulation s(model, {}, executor);
    const Ledger before = s.ledger();
    s.advance_to(0.1);
    const Ledger after = s.ledger();
    EXPECT_GT(s.drain_counts().substeps, 50u);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
    EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-12 * before.angular_momentum.norm());
    EXPECT_LT(std::abs(after.balance_error()), 5e-3 * before.initial);
    EXPECT_GT(after.elastic, 0.01 * before.initial);
  }
}

TEST(SimulationFall, IsAccountedForExactly) {
  Model model = blocks({{}});
  model.gravity = Vec3(0, 0, -9.81);
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  const Vec3 at = mean(s, s.positions(), 0);
  s.advance_to(0.1);
  EXPECT_NEAR(mean(s, s.positions(), 0).z() - at.z(), -9.81 * 0.1 * 0.1 / 2, 1e-12);
  const Ledger& l = s.ledger();
  EXPECT_NEAR(l.external, l.kinetic, 1e-9 * l.kinetic);
  EXPECT_LT((l.momentum - l.impulse).norm(), 1e-12 * l.momentum.norm());
  EXPECT_EQ(s.time(), 0.1);
}

TEST(SimulationDamping, TakesWhatItSays) {
  Model model = blocks({{.velocity = Vec3(1, 0, 0)}});
  model.bodies[0].material.damping = 10;
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  s.advance_to(0.1);
  EXPECT_NEAR(s.velocities()[0].x(), std::exp(-1.0), 0.01);
  EXPECT_LT(std::abs(s.ledger().balance_error()), 1e-6 * s.ledger().initial);
}

Body rigid_body() {
  Body body{"rigid", soft()};
  body.rigid = true;
  return body;
}

TEST(SimulationRigidBody, SpinsWithConstantAngularMomentum) {
  Model model = blocks({{.size = Vec3(0.3, 0.2, 0.05), .body = rigid_body()}});
  for (std::size_t i = 0; i < model.positions.size(); ++i)
    model.velocities[i] = Vec3(1, 2, 3) + Vec3(0.3, 10, 0.1).cross(model.positions[i]);
  SimulationOptions options;
  options.max_step = 1e-3;
  SerialExecutor executor;
  Simulation s(model, options, executor);
  const Ledger before = s.ledger();
  s.advance_to(1);
  const Ledger& after = s.ledger();
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum.norm());
  EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-11 * before.angular_momentum.norm());
  EXPECT_LT(std::abs(after.balance_error()), 1e-4 * before.initial);
  // The body has tumbled, and kept its shape.
  const auto x = s.positions();
  EXPECT_GT((x[1] - x[0] - (model.positions[1] - model.positions[0])).norm(), 0.01);
  for (std::size_t i = 1; i < x.size(); ++i)
    EXPECT_NEAR((x[i] - x[0]).norm(), (model.positions[i] - model.positions[0]).norm(), 1e-12);
}

TEST(SimulationRigidBody, ImpactKeepsMomentumAndAngularMomentum) {
  // The impact is eccentric, so that both bodies rotate.
  Model model =
      blocks({{.velocity = Vec3(5, 0, 0), .body = rigid_body()}, {.at = Vec3(0.25, 0.12, 0.07), .body = rigid_body()}});
  SimulationOptions options;
  options.max_step = 1e-3;
  SerialExecutor executor;
  Simulation s(model, options, executor);
  const Ledger before = s.ledger();
  s.advance_to(0.05);
  const Ledger& after = s.ledger();
  EXPECT_GT(s.drain_counts().inter, 0u);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
  EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 0.01 * before.angular_momentum.norm());
  EXPECT_GT(mean(s, s.velocities(), 1).x(), 0.5);
  EXPECT_GT(after.contact, 0);
  EXPECT_LT(std::abs(after.balance_error()), 1e-3 * before.initial);
}

Model tearing_bar() {
  Model model = blocks({{.nx = 8, .ny = 2, .nz = 2}});
  for (std::size_t i = 0; i < model.positions.size(); ++i)
    model.velocities[i] = Vec3(40 * (model.positions[i].x() - 0.4), 1, 0);
  model.bodies[0].material.failure_stress = 2e5;
  return model;
}

TEST(SimulationSplitting, KeepsMassAndMomentum) {
  SerialExecutor executor;
  Simulation s(tearing_bar(), {}, executor);
  const Ledger before = s.ledger();
  const Index vertices = s.topology().mesh().vertex_count();
  s.advance_to(0.02);
  const Ledger& after = s.ledger();
  EXPECT_GT(s.drain_counts().splits, 0u);
  EXPECT_GT(s.topology().mesh().vertex_count(), vertices);
  EXPECT_EQ(s.positions().size(), s.topology().mesh().vertex_count());
  EXPECT_NEAR(after.mass, before.mass, 1e-13 * before.mass);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-11 * before.momentum.norm());
  EXPECT_LT(std::abs(after.balance_error()), 0.02 * before.initial);
  // A new vertex began at the position of its original (Section 6.3).
  for (Index v = vertices; v < s.topology().mesh().vertex_count(); ++v)
    EXPECT_LT((s.positions()[v] - s.start_positions()[v]).norm(), 0.02 * 40);
}

/// A punch of object 1 that is moved to a block of object 0, 1 cm away, and back.
Model punched_model() {
  Model model = blocks(
      {{.nx = 3},
       {.nx = 1, .ny = 1, .nz = 1, .size = Vec3(0.05, 0.1, 0.1), .at = Vec3(-0.06, 0.06, 0.04), .body = rigid_body()}});
  model.bodies[1].material.friction = model.bodies[0].material.friction = 0.2;
  model.guides.push_back({1, {{0.001, Vec3::Zero()}, {0.011, Vec3(0.03, 0, 0.004)}, {0.02, Vec3(0.01, 0, 0)}}});
  model.gravity = Vec3(0, 1, 0);
  return model;
}

TEST(SimulationGuide, IsLinearBetweenPointsAndConstantBeyond) {
  const Guide guide{0, {{1, Vec3::Zero()}, {3, Vec3(4, 0, 2)}, {4, Vec3(0, 1, 2)}}};
  EXPECT_EQ(guide.displacement(0), Vec3::Zero());
  EXPECT_EQ(guide.displacement(2), Vec3(2, 0, 1));
  EXPECT_EQ(guide.displacement(3), Vec3(4, 0, 2));
  EXPECT_EQ(guide.displacement(3.5), Vec3(2, 0.5, 2));
  EXPECT_EQ(guide.displacement(9), Vec3(0, 1, 2));
}

TEST(SimulationGuide, MovesAsPrescribedAndItsWorkAndImpulseAreBooked) {
  const Model model = punched_model();
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  const Ledger before = s.ledger();
  for (double time : {0.0005, 0.006, 0.011, 0.015, 0.03}) {
    s.advance_to(time);
    for (const Index v : s.topology().mesh().vertices(12))
      EXPECT_EQ(s.positions()[v], model.positions[v] + model.guides[0].displacement(time)) << time;
  }
  const Ledger& after = s.ledger();
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GT(counts.inter, 0u);
  EXPECT_EQ(counts.unresolved, 0u);
  EXPECT_GT(mean(s, s.velocities(), 0).x(), 1) << "it was pushed at 3 m/s";
  EXPECT_GT(after.impulse.x(), 10) << "kg m/s, from the punch alone";
  EXPECT_LT((after.momentum - before.momentum - after.impulse).norm(), 1e-11 * after.momentum.norm());
  EXPECT_LT((after.angular_momentum - before.angular_momentum - after.angular_impulse).norm(),
            0.02 * after.angular_momentum.norm());
  EXPECT_GT(after.external, 0.9 * after.kinetic);
  EXPECT_LT(std::abs(after.balance_error()), 0.03 * after.external);
}

TEST(SimulationGuide, StretchesWhatIsAttachedToIt) {
  Shape bar = block(ElementType::hexahedron, 4, 1, 1);
  bar.elements.back().object = 1;
  Model model;
  model.mesh = bar.mesh();
  for (const Vec3& x : bar.positions) model.positions.push_back(0.1 * x);
  model.velocities.assign(model.positions.size(), Vec3::Zero());
  model.bodies = {{"bar", soft()}, rigid_body()};
  for (Index v = 0; v < model.positions.size(); ++v)
    if (model.positions[v].x() == 0) model.fixed.push_back(v);
  model.guides.push_back({1, {{0, Vec3::Zero()}, {0.2, Vec3(0.03, 0, 0)}}});
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  s.advance_to(0.2);
  const Ledger& after = s.ledger();
  EXPECT_GT(after.elastic, 0.5 * 1e6 * 0.01 * 0.01 / 0.3 * 0.08) << "a tenth longer; E A d^2 / 2 l";
  EXPECT_NEAR(after.elastic + after.kinetic + after.numerical, after.external, 0.02 * after.external);
}

/// A block on a wall that tears when it hits another one, and on which a tool presses.
Model busy_model() {
  Model model = blocks({{.nx = 3, .velocity = Vec3(6, 0, 0)},
                        {ElementType::tetrahedron, 2, 2, 2, Vec3(0.1, 0.1, 0.1), Vec3(0.31, 0.03, 0.01)},
                        {.nx = 1, .ny = 1, .nz = 1, .at = Vec3(0.12, 0.06, 0.203), .body = rigid_body()}});
  model.guides.push_back({2, {{0, Vec3::Zero()}, {0.01, Vec3(0.05, 0, -0.02)}, {0.03, Vec3(0.1, 0, 0.1)}}});
  model.bodies[0].material.failure_stress = 5e4;
  for (std::size_t i = 0; i < model.positions.size(); ++i)
    if (model.positions[i].x() < 0.305) model.velocities[i].x() += 50 * (model.positions[i].x() - 0.15);
  model.bodies[0].material.friction = model.bodies[1].material.friction = 0.3;
  model.walls.push_back({Vec3(0, 0, -0.01), Vec3(0, 0, 1), 0.4});
  model.gravity = Vec3(0, 0, -9.81);
  return model;
}

TEST(SimulationDeterminism, ThreadsAndListsDoNotMatter) {
  SerialExecutor one;
  const std::unique_ptr<Executor> two = make_executor(2);
  const auto with = [](ListConfig lists) {
    SimulationOptions options;
    options.lists = lists;
    return options;
  };
  std::vector<Simulation> all;
  all.emplace_back(busy_model(), with({.use = ListConfig::Use::never}), one);
  all.emplace_back(busy_model(), with({.use = ListConfig::Use::always, .budget = 2e-3, .steps = 10}), *two);
  all.emplace_back(busy_model(), with({.use = ListConfig::Use::automatic}), one);
  for (Simulation& s : all) {
    for (double time : {0.01, 0.03}) s.advance_to(time);
    EXPECT_TRUE(same_bits(s.positions(), all[0].positions()));
    EXPECT_TRUE(same_bits(s.velocities(), all[0].velocities()));
  }
  const SimulationCounts counts = all[0].drain_counts();
  EXPECT_GT(counts.inter, 0u);
  EXPECT_GT(counts.splits, 0u);
}

TEST(SimulationCheckpoint, GoesOnBitForBit) {
  SerialExecutor executor;
  Simulation whole(busy_model(), {}, executor);
  whole.advance_to(0.008);
  EXPECT_GT(whole.drain_counts().inter, 0u);
  ASSERT_GT(whole.topology().mesh().vertex_count(), busy_model().mesh.vertex_count());
  std::ostringstream out;
  Archive writer(out);
  whole.archive(writer);
  Simulation resumed(busy_model(), {}, executor);
  std::istringstream in(out.str());
  Archive reader(in);
  resumed.archive(reader);
  EXPECT_EQ(resumed.time(), whole.time());
  EXPECT_TRUE(same_bits(whole.positions(), resumed.positions()));
  whole.advance_to(0.02);
  resumed.advance_to(0.02);
  EXPECT_TRUE(same_bits(whole.positions(), resumed.positions()));
  EXPECT_TRUE(same_bits(whole.velocities(), resumed.velocities()));
  EXPECT_EQ(whole.ledger().balance_error(), resumed.ledger().balance_error());
  EXPECT_EQ(whole.topology().mesh().vertex_count(), resumed.topology().mesh().vertex_count());
}

TEST(SimulationInput, RefusesWhatDoesNotHoldTogether) {
  SerialExecutor executor;
  const auto refuses = [&](Model model) { EXPECT_THROW(Simulation(model, {}, executor), InputError); };
  Model model = blocks({{}});
  model.velocities.pop_back();
  refuses(model);
  model = blocks({{}});
  model.fixed.push_back(model.mesh.vertex_count());
  refuses(model);
  model = blocks({{}});
  model.bodies.clear();
  refuses(model);
  model = blocks({{}});
  model.positions[3].y() = std::nan("");
  refuses(model);
  model = blocks({{}});
  model.walls.push_back({Vec3::Zero(), Vec3(0, 0, 2)});
  refuses(model);
  const auto guided = [&](std::vector<std::pair<double, Vec3>> path, bool rigid = true) {
    model = blocks({{}});
    model.bodies[0].rigid = rigid;
    model.guides.push_back({0, std::move(path)});
    return model;
  };
  EXPECT_NO_THROW(Simulation(guided({{0, Vec3::Zero()}}), {}, executor));
  refuses(guided({{0, Vec3::Zero()}}, false));
  refuses(guided({}));
  refuses(guided({{0, Vec3::UnitX()}}));
  refuses(guided({{0, Vec3::Zero()}, {0, Vec3::Zero()}}));
  refuses(guided({{0, Vec3::Zero()}, {1, Vec3(0, std::nan(""), 0)}}));
  guided({{0, Vec3::Zero()}});
  model.guides.push_back(model.guides[0]);
  refuses(model);
  guided({{0, Vec3::Zero()}});
  model.fixed.push_back(0);
  refuses(model);
  SimulationOptions options;
  options.pipeline = "nothing";
  EXPECT_THROW(Simulation(blocks({{}}), options, executor), ConfigError);
  Simulation other(blocks({{}, {.at = Vec3(1, 0, 0)}}), {}, executor), s(blocks({{}}), {}, executor);
  std::stringstream stream;
  Archive writer(static_cast<std::ostream&>(stream));
  other.archive(writer);
  Archive reader(static_cast<std::istream&>(stream));
  EXPECT_THROW(s.archive(reader), InputError);
}

}  // namespace
}  // namespace volccd::simulation
