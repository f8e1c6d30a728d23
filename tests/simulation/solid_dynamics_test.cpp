// Internal forces of solids in motion: stable steps, waves, bending, yielding, energy.
#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include <volccd/simulation/elements/material.hpp>

#include "solid_support.hpp"

namespace volccd::simulation::test {
namespace {

/// Greatest frequency of a loop's model near its present state, by power iteration with differences of forces.
double greatest_frequency(Loop& loop, double edge) {
  const std::vector<Vec3> x = loop.x;
  const double e = 1e-7 * edge;
  std::vector<Vec3> u(x.size()), plus;
  for (std::size_t i = 0; i < x.size(); ++i) u[i] = noise3(77, i);
  double squared = 0;
  for (int k = 0; k < 60; ++k) {
    double norm = 0;
    for (std::size_t i = 0; i < x.size(); ++i) norm += loop.mass[i] * u[i].squaredNorm();
    for (Vec3& a : u) a /= std::sqrt(norm / loop.mass[0]);
    for (std::size_t i = 0; i < x.size(); ++i) loop.x[i] = x[i] + e * u[i];
    loop.compute(0);
    plus = loop.force;
    for (std::size_t i = 0; i < x.size(); ++i) loop.x[i] = x[i] - e * u[i];
    loop.compute(0);
    double size = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      u[i] = (loop.force[i] - plus[i]) / (2 * e * loop.mass[i]);
      size += loop.mass[i] * u[i].squaredNorm();
    }
    squared = std::sqrt(size / loop.mass[0]);
  }
  loop.x = x;
  return std::sqrt(squared);
}

TEST(SolidStableStep, BoundsTheGreatestFrequencyOfAnElement) {
  double closest = 0, loosest = 2;
  for (const Material& material : {soft(), steel()}) {
    for (std::uint64_t k = 0; k < 40; ++k) {
      Model model = block(Solid::hexahedra, {1, 1, 1}, 1, material);
      if (k % 2 == 0) {
        model.mesh = Mesh();
        model.mesh.add_vertices(4);
        model.mesh.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}});
        model.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
        model.velocities.resize(4);
      }
      const Vec3 scale = (Vec3::Ones() + 0.8 * noise3(1, k)).eval();
      for (std::size_t i = 0; i < model.positions.size(); ++i) {
        model.positions[i] = scale.cwiseProduct(model.positions[i] + 0.15 * noise3(2 + k, i));
      }
      Loop loop(model);
      // Cells are compressed and stretched, in every third case by half or more.
      for (std::size_t i = 0; i < loop.x.size(); ++i) {
        loop.x[i] += (k % 3 == 0 ? 0.5 : 0.02) * scale.cwiseProduct(noise3(100 + k, i));
        loop.v[i].setZero();
      }
      loop.compute(0);
      const double step = loop.forces->stable_step();
      const double product = step * greatest_frequency(loop, 0.2);
      EXPECT_LE(product, 2.0001) << k;
      if (k % 3 != 0) closest = std::max(closest, product), loosest = std::min(loosest, product);
    }
  }
  EXPECT_GT(closest, 1.5);
  EXPECT_GT(loosest, 0.8);
}

TEST(SolidStableStep, OfACube) {
  Loop loop(block(Solid::hexahedra, {2, 2, 2}, 0.1, soft()));
  loop.compute(0);
  const double bulk = lame_lambda(soft()) + 2.0 / 3 * shear_modulus(soft());
  const double inviscid = 0.1 * std::sqrt(soft().density / (3 * bulk));
  EXPECT_LT(loop.forces->stable_step(), inviscid);
  EXPECT_GT(loop.forces->stable_step(), 0.85 * inviscid);
}

TEST(SolidStableStep, LimitsTheStrainOfAStep) {
  for (const Solid type : {Solid::tetrahedra, Solid::hexahedra}) {
    Loop loop(block(type, {2, 2, 2}, 0.1, soft()));
    loop.compute(0);
    const double at_rest = loop.forces->stable_step(), rate = 1 / at_rest;
    // Stretched to twice the length, and getting longer; the rate is that of the present length.
    for (std::size_t i = 0; i < loop.x.size(); ++i) {
      loop.x[i].z() *= 2;
      loop.v[i] = Vec3(0, 0, rate * loop.x[i].z());
    }
    loop.compute(0);
    EXPECT_NEAR(loop.forces->stable_step(), 0.1 / rate, 1e-9 / rate);
    for (std::size_t i = 0; i < loop.x.size(); ++i) loop.v[i] = rate * Vec3(0, 0, 1).cross(loop.x[i]);
    loop.compute(0);
    EXPECT_GT(loop.forces->stable_step(), 0.4 / rate) << "a rotation";
  }
}

class SolidWaves : public testing::TestWithParam<Solid> {};
INSTANTIATE_TEST_SUITE_P(Types, SolidWaves, testing::Values(Solid::tetrahedra, Solid::hexahedra));

TEST_P(SolidWaves, TravelAlongABarAtTheSpeedOfTheRod) {
  // A slender bar, fixed at one end, is released from its first mode. A quarter of the period is length / speed.
  const int n = 40;
  const double edge = 0.01, length = n * edge;
  Loop loop(block(GetParam(), {n, 1, 1}, edge, soft()));
  for (Vec3& x : loop.x) x[0] += 1e-5 * length * std::sin(std::numbers::pi / 2 * x[0] / length);
  loop.compute(0);
  const double dt = 0.9 * loop.forces->stable_step();
  const Index tip = static_cast<Index>(n);
  double time = 0.5 * dt, before = 0, crossed = 0;
  for (int k = 0; k < 20000 && crossed == 0; ++k, time += dt) {
    before = loop.x[tip][0] - length;
    loop.step(dt, [&](std::vector<Vec3>& v) {
      for (std::size_t i = 0; i < v.size(); ++i) {
        if (loop.model.positions[i][0] == 0) v[i][0] = 0;
      }
    });
    const double now = loop.x[tip][0] - length;
    if (before > 0 && now <= 0) crossed = time - 0.5 * dt + dt * before / (before - now);
  }
  const double speed = std::sqrt(soft().youngs_modulus / soft().density);
  EXPECT_NEAR(length / crossed / speed, 1, 0.01);
}

TEST(SolidBending, CantileverOfHexahedra) {
  const double height = 0.1, load = 0.5;
  double error[2];
  for (int mesh = 0; mesh < 2; ++mesh) {
    const int n = mesh == 0 ? 2 : 4;
    Material material = soft();
    material.poisson_ratio = 0;  // the formula does not include the clamping across the bar
    Loop loop(block(Solid::hexahedra, {6 * n, n, n}, height / n, material));
    const double length = 6 * height, inertia = std::pow(height, 4) / 12, e = soft().youngs_modulus;
    const double shear = shear_modulus(material) * 5 / 6 * height * height;
    const double expected = load * (std::pow(length, 3) / (3 * e * inertia) + length / shear);
    loop.compute(0);
    const double dt = 0.9 * loop.forces->stable_step();
    // The damping is critical for the first mode.
    const double frequency = 3.516 * std::sqrt(e * inertia / (1000 * height * height)) / (length * length);
    const int steps = static_cast<int>(9 / frequency / dt);
    double tip = 0;
    for (int k = 0; k < steps; ++k) {
      for (std::size_t i = 0; i < loop.x.size(); ++i) {
        // Distributes the force evenly over the end.
        if (loop.model.positions[i][0] < length - 1e-9) continue;
        const Vec3 p = loop.model.positions[i] / height;
        const double wy = p[1] < 0.01 || p[1] > 0.99 ? 0.5 : 1, wz = p[2] < 0.01 || p[2] > 0.99 ? 0.5 : 1;
        loop.force[i][2] -= load * wy * wz / (n * n);
      }
      loop.step(dt, [&](std::vector<Vec3>& v) {
        for (std::size_t i = 0; i < v.size(); ++i) {
          v[i] *= 1 - 2 * frequency * dt;
          if (loop.model.positions[i][0] == 0) v[i].setZero();
        }
      });
    }
    for (std::size_t i = 0; i < loop.x.size(); ++i) {
      if (loop.model.positions[i][0] > length - 1e-9) tip = std::max(tip, loop.model.positions[i][2] - loop.x[i][2]);
    }
    EXPECT_LT(expected, 0.01 * length);
    error[mesh] = tip / expected - 1;
  }
  EXPECT_NEAR(error[0], 0, 0.01);
  EXPECT_NEAR(error[1], 0, 0.005);
}

/// Stretches a unit cube of steel to a logarithmic strain at its rate with free sides; returns the true stress along x.
/// `factor`: factor by which the rate increases the yield stress.
double pull(Solid solid, const Material& material, double strain, double rate, double factor = 1) {
  Loop loop(block(solid, {1, 1, 1}, 1, material));
  loop.compute(0);
  const int steps = static_cast<int>(strain / rate / (0.8 * loop.forces->stable_step())) + 1;
  const double dt = strain / rate / steps;
  for (int k = 0; k < steps; ++k) {
    loop.step(dt, [&](std::vector<Vec3>& v) {
      for (std::size_t i = 0; i < v.size(); ++i) {
        const double far = loop.model.positions[i][0];
        v[i] *= 0.99;
        v[i][0] = far * rate * loop.x[i][0];
      }
    });
  }
  const Eigen::Matrix3d s = loop.mean_stress();
  EXPECT_LT(std::abs(s(1, 1)) + std::abs(s(2, 2)), 0.01 * std::abs(s(0, 0)));
  double plastic = 0, volume = 0;
  for (const VertexStress& at : loop.stress()) plastic += at.plastic_strain, volume += at.volume;
  EXPECT_NEAR(plastic / volume, strain - s(0, 0) / material.youngs_modulus, 0.004 * strain);
  EXPECT_NEAR(loop.forces->plastic_work(), (plastic / volume) * 0.5 * (s(0, 0) + factor * material.yield_stress),
              0.02 * s(0, 0) * strain);
  return s(0, 0);
}

class SolidYield : public testing::TestWithParam<Solid> {};
INSTANTIATE_TEST_SUITE_P(Types, SolidYield, testing::Values(Solid::tetrahedra, Solid::hexahedra));

TEST_P(SolidYield, PullFollowsTheCurve) {
  // The motion is slow compared with the time of a wave through the body: 2e-4 s.
  EXPECT_NEAR(pull(GetParam(), steel(), 0.05, 1), 4e8 + 1e9 * (0.05 - 0.00225), 3e6);
  EXPECT_NEAR(pull(GetParam(), steel(), 0.20, 5), 4e8 + 1e9 * (0.20 - 0.003), 6e6);
}

TEST_P(SolidYield, RateRaisesTheCurve) {
  Material m = steel();
  m.rate_factor = 0.05;
  m.reference_rate = 0.01;
  const double factor = 1 + 0.05 * std::log(1 / 0.01), plastic = 0.05 - 0.0028;
  EXPECT_NEAR(pull(GetParam(), m, 0.05, 1, factor), factor * (4e8 + 1e9 * plastic), 6e6);
}

TEST(SolidYield, IncrementSolvesItsEquation) {
  Material m = steel();
  for (std::uint64_t k = 0; k < 300; ++k) {
    m.rate_factor = k % 3 == 0 ? 0 : std::pow(10, -2 + 2 * noise(1, k));
    m.hardening_modulus = k % 2 == 0 ? 0 : 1e9;
    const double trial = 4e8 * std::pow(10, 2 * noise(2, k)), dt = std::pow(10, -6 + 3 * noise(3, k)), strain = 0.1;
    const double scale = 0.9, slope = 2.3e11;
    const double d = plastic_increment(m, trial, slope, scale, strain, dt);
    if (trial <= scale * yield_stress(m, strain, 0)) {
      EXPECT_EQ(d, 0);
    } else {
      EXPECT_GE(d, 0);
      EXPECT_NEAR(trial - slope * d, scale * yield_stress(m, strain + d, d / dt), 1e-9 * trial);
    }
  }
}

TEST(SolidEnergy, IsAccountedForInAnImpact) {
  // A block hits a wall that fixes its first layer: shock, flow, rebound.
  Loop loop(block(Solid::both, {8, 4, 4}, 0.01, steel()));
  for (Vec3& v : loop.v) v = Vec3(-150, 20, 0);
  const auto hold = [&](std::vector<Vec3>& v) {
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (loop.model.positions[i][0] == 0) v[i].setZero();
    }
  };
  loop.compute(0);
  hold(loop.v);
  const double initial = loop.kinetic(), dt = 0.5 * loop.forces->stable_step();
  double kinetic = 0;
  for (int k = 0; k < 400; ++k) {
    const double before = loop.kinetic();
    loop.step(dt, hold);
    if (k > 0) kinetic = 0.5 * (before + loop.kinetic());
  }
  const double elastic = loop.forces->elastic_energy(), plastic = loop.forces->plastic_work();
  const double numerical = loop.forces->numerical_work();
  EXPECT_GT(plastic, 0.3 * initial);
  EXPECT_GT(numerical, 0);
  EXPECT_LT(numerical, 0.2 * initial);
  EXPECT_NEAR(kinetic + elastic + plastic + numerical, initial, 0.002 * initial);
}

TEST(SolidEnergy, StaysWhereAnElasticBodyTurnsInsideOut) {
  // Tetrahedra are pushed through a plane and back: no energy is gained, and the shape returns.
  Loop loop(block(Solid::tetrahedra, {2, 2, 2}, 0.1, soft()));
  for (Vec3& x : loop.x) x[2] *= -1;
  loop.compute(0);
  const double initial = loop.forces->elastic_energy();
  for (int k = 0; k < 1500; ++k) {
    loop.step(0.8 * loop.forces->stable_step(), [](std::vector<Vec3>& v) {
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = 0.995 * v[i] + 1e-6 * noise3(5, i);
    });
    ASSERT_LT(loop.kinetic() + loop.forces->elastic_energy(), 1.02 * initial);
  }
  EXPECT_LT(loop.forces->elastic_energy(), 0.01 * initial);
}

}  // namespace
}  // namespace volccd::simulation::test
