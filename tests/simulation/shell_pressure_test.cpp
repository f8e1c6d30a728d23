// Pressure loads.
#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/simulation/elements/pressure_forces.hpp>

#include "shell_support.hpp"

namespace volccd::simulation::shell_test {
namespace {

Model octahedron() {
  Model model = one_part(steel(), 0.01);
  add_vertices(model, {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
  for (Index x : {0u, 1u})
    for (Index y : {2u, 3u})
      for (Index z : {4u, 5u}) {
        const bool flip = (x + y + z) % 2 == 1;
        add_triangle(model, x, flip ? z : y, flip ? y : z);
      }
  model.pressures.push_back({0, {{0, 100}, {1, 300}}});
  return model;
}

TEST(ShellPressure, ClosedSurfaceHasNoNetForceOrMoment) {
  Model model = octahedron();
  PressureForces pressure(model);
  Random random(1);
  for (Vec3& x : model.positions) x += random_vector(random, 0.4);
  std::vector<Vec3> v(6), force(6, Vec3::Zero());
  for (Vec3& u : v) u = random_vector(random, 1);
  SerialExecutor serial;
  const double power = pressure.add_forces(model.positions, v, 0.5, serial, force);
  Vec3 net = Vec3::Zero(), moment = Vec3::Zero();
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    net += force[i];
    moment += model.positions[i].cross(force[i]);
    sum += force[i].dot(v[i]);
    EXPECT_GT(force[i].norm(), 1);
  }
  EXPECT_LT(net.norm() + moment.norm(), 1e-12 * 200);
  EXPECT_NEAR(power, sum, 1e-12 * 200);
  // The power is the pressure times the rate of change of the volume.
  const auto volume = [&](double t) {
    double six = 0;
    for (Index e = 0; e < 8; ++e) {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k) {
        const Index p = model.mesh.vertices(e)[static_cast<std::size_t>(k)];
        corners.col(k) = model.positions[p] + t * v[p];
      }
      six += corners.determinant();
    }
    return six / 6;
  };
  EXPECT_GT(volume(0), 0.5);
  EXPECT_NEAR(power, 200 * (volume(1e-4) - volume(-1e-4)) / 2e-4, 1e-4);
}

TEST(ShellPressure, FlatSheetGetsPressureTimesArea) {
  Model model = sheet(7, 5, 0.1, 0.2, steel(), 0.01);
  model.pressures.push_back({0, {{1, 10}, {3, 50}}});
  model.pressures.push_back({0, {{0, 1}}});
  PressureForces pressure(model);
  SerialExecutor serial;
  for (const auto& [time, value] : {std::pair(0.0, 11.0), std::pair(2.0, 31.0), std::pair(9.0, 51.0)}) {
    std::vector<Vec3> v(model.positions.size(), Vec3(1, 2, 3)), force(model.positions.size(), Vec3::Zero());
    const double power = pressure.add_forces(model.positions, v, time, serial, force);
    Vec3 net = Vec3::Zero();
    for (const Vec3& f : force) net += f;
    EXPECT_LT((net - Vec3(0, 0, value * 0.7)).norm(), 1e-12 * value);
    EXPECT_NEAR(power, 3 * value * 0.7, 1e-12 * value);
  }
  model.mesh.remove_element(0);
  pressure.update(model.mesh);
  std::vector<Vec3> v(model.positions.size(), Vec3::UnitZ()), force(model.positions.size(), Vec3::Zero());
  EXPECT_NEAR(pressure.add_forces(model.positions, v, 0, serial, force), 11 * (0.7 - 0.01), 1e-12);
}

TEST(ShellPressureThreads, SameBitsForAnyNumber) {
  Model model = sheet(90, 60, 0.1, 0.1, steel(), 0.01);
  Random random(2);
  std::vector<Vec3> v;
  for (Vec3& x : model.positions) {
    x += random_vector(random, 0.1);
    v.push_back(random_vector(random, 1));
  }
  model.pressures.push_back({0, {{0, 7}}});
  PressureForces pressure(model);
  std::vector<Vec3> f(v.size(), Vec3::Zero()), g = f;
  SerialExecutor one;
  const auto three = make_thread_executor(3);
  EXPECT_EQ(pressure.add_forces(model.positions, v, 0, one, f), pressure.add_forces(model.positions, v, 0, *three, g));
  EXPECT_EQ(f, g);
}

TEST(ShellPressure, RefusesBadCurves) {
  const auto refused = [](const Pressure& load) {
    Model model = octahedron();
    model.pressures = {load};
    EXPECT_THROW(PressureForces{model}, InputError);
  };
  refused({1, {{0, 1}}});
  refused({0, {}});
  refused({0, {{1, 1}, {1, 2}}});
  refused({0, {{0, std::nan("")}}});
}

}  // namespace
}  // namespace volccd::simulation::shell_test
