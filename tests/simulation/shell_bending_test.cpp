// Bending of shells: hinges, plastic hinges, joints; and threads, checkpoints, edits.
#include <sstream>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <volccd/core/error.hpp>

#include "shell_support.hpp"

namespace volccd::simulation::shell_test {
namespace {

constexpr double kPi = 3.141592653589793;

double plate_stiffness(const Material& m, double h) {
  return m.youngs_modulus * h * h * h / (12 * (1 - m.poisson_ratio * m.poisson_ratio));
}

/// Two triangles with a common edge of length 2 and heights of 1 form a flat sheet; vertex 3 rotates about the edge.
Model flap(const Material& material, double thickness, bool same_sense = true) {
  Model model = one_part(material, thickness);
  add_vertices(model, {{0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}});
  add_triangle(model, 0, 1, 2);
  if (same_sense) add_triangle(model, 1, 0, 3);
  if (!same_sense) add_triangle(model, 0, 1, 3);
  return model;
}
void turn(Loop& loop, double angle) { loop.x[3] = {std::cos(angle), 0, std::sin(angle)}; }
/// Moment of the whole edge, computed from the force on the rotated vertex; positive if it opposes a rotation towards
/// +z.
double moment(const Loop& loop, double angle) { return -loop.force[3].dot(Vec3(-std::sin(angle), 0, std::cos(angle))); }

TEST(ShellBending, CylinderHasTheEnergyOfAPlate) {
  const double radius = 5, a = 0.1, b = 0.07, h = 0.01;
  Loop loop(sheet(20, 6, a, b, steel(), h));
  // Chords keep their lengths, so that the membrane has no forces.
  const double angle = 2 * std::asin(a / 2 / radius);
  for (Vec3& x : loop.x) x = {radius * std::sin(x.x() / a * angle), x.y(), radius * (1 - std::cos(x.x() / a * angle))};
  loop.compute(0);
  const double expected = 0.5 * plate_stiffness(steel(), h) / (radius * radius) * (19 * a) * (6 * b);
  EXPECT_NEAR(loop.shells->elastic_energy(), expected, 2e-4 * expected);
}

/// Columns of equilateral triangles with edge length a across x: `along` columns of `across` edges.
Model equilateral(Index along, Index across, double a, const Material& material, double thickness) {
  Model model = one_part(material, thickness);
  std::vector<Vec3> positions;
  for (Index j = 0; j <= along; ++j)
    for (Index i = 0; i <= across; ++i) positions.push_back({a * std::sqrt(0.75) * j, a * (i + 0.5 * (j % 2)), 0});
  add_vertices(model, positions);
  for (Index j = 0; j < along; ++j) {
    for (Index i = 0; i < across; ++i) {
      const Index p = j * (across + 1) + i, q = p + 1, s = p + across + 1, r = s + 1;
      add_triangle(model, p, q, j % 2 == 0 ? s : r);
      if (j % 2 == 0) add_triangle(model, q, r, s);
      if (j % 2 == 1) add_triangle(model, p, r, s);
    }
  }
  return model;
}

TEST(ShellBending, CylinderInAnyDirectionOnEquilateralTriangles) {
  constexpr Index n = 30;
  const double a = 0.01, area = n * n * std::sqrt(0.75) * a * a;
  const Model model = equilateral(n, n, a, steel(), 0.001);
  const double curvature = 1e-4;  // so small that the membrane has no influence
  for (const double direction : {0.0, 0.4, 1.0, kPi / 2}) {
    Loop loop(model);
    for (Vec3& x : loop.x) {
      const double s = x.x() * std::cos(direction) + x.y() * std::sin(direction);
      x.z() = 0.5 * curvature * s * s;
    }
    loop.compute(0);
    const double expected = 0.5 * plate_stiffness(steel(), 0.001) * curvature * curvature * area;
    EXPECT_NEAR(loop.shells->elastic_energy(), expected, 0.04 * expected) << direction;  // the rim has no hinges
  }
}

TEST(ShellBending, BeamOnTwoSupportsBendsAsTheFormulaSays) {
  constexpr Index columns = 20, across = 4;
  const double a = 0.1, h = 0.05, width = across * a, length = columns * a * std::sqrt(0.75), force = 1e4;
  Loop loop(equilateral(columns, across, a, steel(), h));
  for (std::size_t i = 0; i <= across; ++i) loop.held[i] = loop.held[columns * (across + 1) + i] = true;
  const double inertia = width * h * h * h / 12;
  const double frequency = kPi * kPi / (length * length) * std::sqrt(2e11 * inertia / (7800 * width * h));
  const double dt = 0.9 * loop.shells->stable_step();
  const auto load = [&](std::vector<Vec3>& f) {
    for (Index i = 0; i <= across; ++i) f[columns / 2 * (across + 1) + i].z() += force / (across + 1);
  };
  loop.compute(0);
  loop.run(static_cast<int>(15 / frequency / dt), dt, load, 1.6 * frequency);
  const double expected = force * length * length * length / (48 * 2e11 * inertia);
  double middle = 0;
  for (Index i = 0; i <= across; ++i) middle += loop.x[columns / 2 * (across + 1) + i].z() / (across + 1);
  EXPECT_LT(middle, 0.2 * h);  // otherwise the membrane would contribute
  // 2.4 % because hinges bend as if Poisson's ratio were -1/3; the rest because the rims have no hinges.
  EXPECT_NEAR(middle, expected, 0.07 * expected);
}

TEST(ShellBending, PlasticHingeKeepsAnAngle) {
  Material m = yielding_steel();
  m.hardening_modulus = 0;
  for (const bool same_sense : {true, false}) {
    const double h = 0.05, stiffness = plate_stiffness(m, h) * 4 / 2, full = 3e8 * h * h / 4 * 2;
    Loop loop(flap(m, h, same_sense));
    const double limit = full / stiffness;
    double angle = 0.9 * limit;
    turn(loop, angle);
    loop.compute(1e-3);
    EXPECT_NEAR(moment(loop, angle), 0.9 * full, 1e-9 * full);
    EXPECT_EQ(loop.shells->plastic_work(), 0);
    for (int k = 1; k <= 50; ++k) {
      angle = limit * (1 + 0.2 * k);
      turn(loop, angle);
      loop.compute(1e-3);
      ASSERT_NEAR(moment(loop, angle), full, 1e-9 * full);
    }
    EXPECT_NEAR(loop.shells->plastic_work(), full * 10 * limit, 1e-9 * full * limit);
    turn(loop, 10 * limit);
    loop.compute(1e-3);
    EXPECT_NEAR(moment(loop, 10 * limit), 0, 1e-9 * full);
    EXPECT_LT(loop.shells->elastic_energy(), 1e-9 * full * limit);
  }
}

TEST(ShellBending, PlasticHingeHardensAndFeelsTheRate) {
  Material m = yielding_steel();
  m.hardening_modulus = 2e10;
  const double h = 0.05, full = 3e8 * h * h / 4 * 2, per_angle = h / 4 * 2 / 2;
  Loop loop(flap(m, h));
  turn(loop, 0.5);
  loop.compute(1e-3);
  const double plastic = 0.5 - moment(loop, 0.5) / (plate_stiffness(m, h) * 2);
  EXPECT_NEAR(moment(loop, 0.5), full * (1 + 2e10 / 3e8 * per_angle * plastic), 1e-9 * full);
  m.hardening_modulus = 0;
  m.rate_factor = 0.1;
  Loop fast(flap(m, h));
  turn(fast, 0.5);
  fast.compute(1e-3);
  const double rate = per_angle * (0.5 - moment(fast, 0.5) / (plate_stiffness(m, h) * 2)) / 1e-3;
  EXPECT_NEAR(moment(fast, 0.5), full * (1 + 0.1 * std::log(rate)), 1e-9 * full);
}

TEST(ShellBending, NumberingMakesNoDifference) {
  Loop a(flap(steel(), 0.05, true)), b(flap(steel(), 0.05, false));
  for (Loop* loop : {&a, &b}) {
    turn(*loop, 0.7);
    loop->compute(0);
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((a.force[i] - b.force[i]).norm(), 1e-12 * a.greatest_force());
  EXPECT_GT(moment(a, 0.7), 0);
}

TEST(ShellBending, UnfoldsFromFlatlyFolded) {
  Model model = flap(steel(), 0.01);
  model.positions[3] = {-1, 0, 0};  // at the position of vertex 2
  Loop loop(model);
  const double k = plate_stiffness(steel(), 0.01) * 2;
  for (const double side : {1.0, -1.0}) {
    for (int i = 0; i <= 60; ++i) {  // a full turn back to the initial position
      const double angle = kPi + side * 2 * kPi * i / 60;
      turn(loop, angle);
      loop.compute(1e-6);
      ASSERT_NEAR(loop.shells->elastic_energy(), 0.5 * k * std::pow(2 * kPi * i / 60, 2), 1e-6 * k) << i;
    }
    for (int i = 60; i >= 0; --i) {
      turn(loop, kPi + side * 2 * kPi * i / 60);
      loop.compute(1e-6);
    }
  }
  EXPECT_LT(loop.shells->elastic_energy(), 1e-12 * k);
}

TEST(ShellBending, JointOfThreeIsAsStiffAsTheSheetThroughIt) {
  Model model = flap(steel(), 0.05);
  add_vertices(model, {{0, 0, 1}});
  add_triangle(model, 0, 1, 4);
  Loop loop(model), two(flap(steel(), 0.05));
  EXPECT_EQ(loop.shells->hinge_count(), 3u);
  turn(two, 0.1);
  two.compute(0);
  turn(loop, 0.1);
  loop.x[4] = {-std::sin(0.05), 0, std::cos(0.05)};  // the rib rotates freely by half of the angle
  loop.compute(0);
  EXPECT_NEAR(loop.shells->elastic_energy(), two.shells->elastic_energy(), 1e-9 * two.shells->elastic_energy());
  EXPECT_NEAR(moment(loop, 0.1), moment(two, 0.1), 1e-9 * moment(two, 0.1));
  EXPECT_LT(loop.force[4].norm(), 1e-9 * moment(two, 0.1));
}

TEST(ShellBending, RigidNeighbourClamps) {
  Model model = flap(steel(), 0.05);
  model.bodies.push_back(model.bodies[0]);
  model.bodies[1].rigid = true;
  model.mesh.remove_element(0);
  add_triangle(model, 0, 1, 2, 1);
  Loop loop(model);
  EXPECT_EQ(loop.shells->triangle_count(), 1u);
  turn(loop, 0.1);
  loop.compute(0);
  EXPECT_NEAR(moment(loop, 0.1), 0.1 * plate_stiffness(steel(), 0.05) * 4, 1e-5 * moment(loop, 0.1));
}

/// A sheet with many blocks that is hit in its middle.
Loop struck(Index n) {
  Model model = sheet(n, n, 0.01, 0.01, yielding_steel(), 0.002, 0.1);
  Loop loop(model);
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    const Vec3 from = loop.x[i] - Vec3(0.005 * n, 0.005 * n, 0);
    if (from.norm() < 0.002 * n) loop.v[i] = {0, 0, 60};
  }
  loop.compute(0);
  return loop;
}

TEST(ShellThreads, SameBitsForAnyNumber) {
  Loop loop = struck(40);
  ShellForces serial(loop.model), parallel(loop.model);
  SerialExecutor one;
  const auto three = make_thread_executor(3);
  std::vector<Vec3> f(loop.x.size()), g(loop.x.size());
  const double dt = 0.8 * loop.shells->stable_step();
  for (int k = 0; k < 60; ++k) {
    loop.run(1, dt);
    f.assign(f.size(), Vec3::Zero());
    g.assign(g.size(), Vec3::Zero());
    serial.add_forces(loop.x, loop.v, dt, one, f);
    parallel.add_forces(loop.x, loop.v, dt, *three, g);
    ASSERT_EQ(f, g);
    ASSERT_EQ(f, loop.force);
    ASSERT_EQ(serial.stable_step(), parallel.stable_step());
    ASSERT_EQ(serial.elastic_energy(), parallel.elastic_energy());
  }
  EXPECT_GT(serial.plastic_work(), 0);
  EXPECT_EQ(serial.plastic_work(), parallel.plastic_work());
  EXPECT_EQ(serial.numerical_work(), parallel.numerical_work());
}

TEST(ShellForces, SameBitsForEveryInstructionSet) {
  std::vector<std::vector<Vec3>> forces;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    hwy::GetChosenTarget().DeInit();
    Loop loop = struck(16);
    loop.run(100, 0.8 * loop.shells->stable_step());
    EXPECT_GT(loop.shells->plastic_work(), 0);
    forces.push_back(loop.force);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
  EXPECT_GE(forces.size(), 2u);
  for (const auto& force : forces) EXPECT_EQ(force, forces.front());
}

TEST(ShellForces, EnergyIsBalancedThroughYielding) {
  Loop loop = struck(24);
  const double start = loop.kinetic_energy();
  loop.run(400, 0.5 * loop.shells->stable_step());
  const ShellForces& s = *loop.shells;
  EXPECT_GT(s.plastic_work(), 0.2 * start);
  EXPECT_NEAR(loop.kinetic_energy() + s.elastic_energy() + s.plastic_work() + s.numerical_work(), start, 0.01 * start);
}

TEST(ShellArchive, GoesOnAsIfNothingHadHappened) {
  Loop loop = struck(12);
  const double dt = 0.8 * loop.shells->stable_step();
  loop.run(100, dt);
  std::stringstream stream;
  {
    Archive out(static_cast<std::ostream&>(stream));
    loop.shells->archive(out);
  }
  ShellForces again(loop.model);
  Archive in(static_cast<std::istream&>(stream));
  again.archive(in);
  EXPECT_EQ(again.stable_step(), loop.shells->stable_step());
  EXPECT_EQ(again.elastic_energy(), loop.shells->elastic_energy());
  EXPECT_EQ(again.plastic_work(), loop.shells->plastic_work());
  EXPECT_EQ(again.numerical_work(), loop.shells->numerical_work());
  std::vector<VertexStress> stress(loop.x.size());
  again.add_vertex_stress(stress);
  EXPECT_EQ(stress[50].stress, loop.stress()[50].stress);
  for (int k = 0; k < 20; ++k) {
    loop.run(1, dt);
    std::vector<Vec3> force(loop.x.size(), Vec3::Zero());
    SerialExecutor serial;
    again.add_forces(loop.x, loop.v, dt, serial, force);
    ASSERT_EQ(force, loop.force);
  }
  std::stringstream short_stream(stream.str().substr(0, stream.str().size() / 2));
  Archive cut(static_cast<std::istream&>(short_stream));
  EXPECT_THROW(again.archive(cut), InputError);
}

TEST(ShellArchive, KeepsFullTurns) {
  Loop loop(flap(steel(), 0.01));
  for (int i = 0; i <= 15; ++i) {
    turn(loop, 0.1 * kPi * i);
    loop.compute(1e-6);
  }
  std::stringstream stream;
  {
    Archive out(static_cast<std::ostream&>(stream));
    loop.shells->archive(out);
  }
  ShellForces again(loop.model);
  Archive in(static_cast<std::istream&>(stream));
  again.archive(in);
  loop.compute(0);
  std::vector<Vec3> force(4, Vec3::Zero());
  SerialExecutor serial;
  again.add_forces(loop.x, loop.v, 0, serial, force);
  EXPECT_EQ(force, loop.force);
}

/// Gives every triangle vertices of its own.
ElementHeritage shatter(Model& model, std::vector<Vec3>& x) {
  ElementHeritage heritage;
  const Index slots = model.mesh.element_slots();
  for (Index slot = 0; slot < slots; ++slot) {
    const auto span = model.mesh.vertices(slot);
    const std::vector<Index> old(span.begin(), span.end());
    const Index first = model.mesh.vertex_count();
    std::vector<Vec3> reference;
    for (const Index v : old) {
      reference.push_back(model.positions[v]);
      x.push_back(x[v]);
    }
    add_vertices(model, reference);
    const std::int64_t id = model.mesh.element_id(slot);
    model.mesh.remove_element(slot);
    heritage.removed.push_back(slot);
    heritage.added.push_back(
        model.mesh.add_element({.type = ElementType::triangle, .vertices = {first, first + 1, first + 2}, .id = id}));
    heritage.parents.push_back(slot);
  }
  return heritage;
}

TEST(ShellUpdate, PiecesKeepTheirState) {
  Loop loop = struck(8);
  loop.run(60, 0.8 * loop.shells->stable_step());
  ASSERT_GT(loop.shells->plastic_work(), 0);
  std::vector<Eigen::Matrix3d> before;
  const auto total = [](const std::vector<VertexStress>& all) {
    VertexStress sum;
    for (const VertexStress& s : all) {
      sum.stress += s.stress;
      sum.plastic_strain += s.plastic_strain;
      sum.volume += s.volume;
    }
    return sum;
  };
  const VertexStress whole = total(loop.stress());
  const double plastic = loop.shells->plastic_work();
  Model model = loop.model;
  std::vector<Vec3> x = loop.x;
  const ElementHeritage heritage = shatter(model, x);
  loop.shells->update(model.mesh, model.positions, loop.x, heritage);
  EXPECT_EQ(loop.shells->hinge_count(), 0u);
  EXPECT_EQ(loop.shells->plastic_work(), plastic);
  loop.x = x;
  loop.v.assign(x.size(), Vec3::Zero());
  for (int k = 0; k < 2; ++k) {  // directly after the edit, and after a call
    const VertexStress pieces = total(loop.stress());
    EXPECT_LT((pieces.stress - whole.stress).norm(), 1e-9 * whole.stress.norm());
    EXPECT_NEAR(pieces.plastic_strain, whole.plastic_strain, 1e-12 * whole.plastic_strain);
    EXPECT_NEAR(pieces.volume, whole.volume, 1e-12 * whole.volume);
    loop.compute(0);
  }
}

TEST(ShellUpdate, HingesKeepTheirAngle) {
  Material m = yielding_steel();
  for (const bool same_sense : {true, false}) {
    for (const bool exchange : {true, false}) {
      Model model = flap(m, 0.05, same_sense);
      Loop loop(model);
      turn(loop, 0.8);
      loop.compute(1e-3);
      const std::vector<Vec3> force = loop.force;
      ASSERT_GT(loop.shells->plastic_work(), 0);
      // Both triangles are replaced, in each other's slots or in their own.
      ElementHeritage heritage;
      std::vector<Index> vertices[2];
      for (Index slot : {0u, 1u}) {
        vertices[slot].assign(model.mesh.vertices(slot).begin(), model.mesh.vertices(slot).end());
        model.mesh.remove_element(slot);
        heritage.removed.push_back(slot);
      }
      for (Index k : {0u, 1u}) {
        const Index parent = exchange ? k : 1 - k;
        heritage.added.push_back(
            model.mesh.add_element({.type = ElementType::triangle, .vertices = vertices[parent], .id = 10 + k}));
        heritage.parents.push_back(parent);
      }
      loop.shells->update(model.mesh, model.positions, loop.x, heritage);
      loop.compute(0);
      for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((loop.force[i] - force[i]).norm(), 1e-9 * loop.greatest_force());
    }
  }
}

TEST(ShellUpdate, WeldedSheetsRestAsTheyAreFound) {
  Model model = one_part(steel(), 0.01);
  // Two separate triangles move together; vertices 3 and 4 merge into 0 and 1.
  add_vertices(model, {{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}, {3, 0, 0}, {3, 1, 0}, {4, 0.5, 0}});
  add_triangle(model, 0, 1, 2);
  add_triangle(model, 4, 3, 5);
  Loop loop(model);
  std::vector<double> mass = loop.mass;
  loop.x[3] = {0, 0, 0};
  loop.x[4] = {0, 1, 0};
  loop.x[5] = {0.6, 0.5, 0.8};
  loop.compute(1e-6);
  EXPECT_LT(loop.greatest_force(), 1e-3);
  model.mesh.remove_element(1);
  const Index added = model.mesh.add_element({.type = ElementType::triangle, .vertices = {1, 0, 5}, .id = 1});
  loop.shells->update(model.mesh, model.positions, loop.x, {{1}, {added}, {1}});
  EXPECT_EQ(loop.shells->hinge_count(), 1u);
  std::stringstream stream;  // before the first call of add_forces()
  {
    Archive out(static_cast<std::ostream&>(stream));
    loop.shells->archive(out);
  }
  model.positions[5] = {4, 0.5, 0};
  Model edited = model;
  ShellForces again(edited);
  Archive in(static_cast<std::istream&>(stream));
  again.archive(in);
  loop.compute(1e-6);
  EXPECT_LT(loop.greatest_force(), 1e-3);
  std::vector<Vec3> force(6, Vec3::Zero());
  SerialExecutor serial;
  again.add_forces(loop.x, loop.v, 1e-6, serial, force);
  EXPECT_EQ(force, loop.force);
  std::vector<double> merged(6, 0);
  loop.shells->add_masses(merged);
  EXPECT_NEAR(merged[0] + merged[1] + merged[2] + merged[5], mass[0] + mass[1] + mass[2] + mass[3] + mass[4] + mass[5],
              1e-9 * mass[0]);
  loop.x[5] = {1, 0.5, 0};
  loop.compute(1e-6);
  EXPECT_NEAR(loop.shells->elastic_energy(), 0.5 * plate_stiffness(steel(), 0.01) * std::pow(std::atan2(0.8, 0.6), 2),
              1e-3 * loop.shells->elastic_energy());
}

}  // namespace
}  // namespace volccd::simulation::shell_test
