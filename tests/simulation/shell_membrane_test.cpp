// Shells as membranes: patch tests, balance, energy, waves, yielding, degenerate shapes.
#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <volccd/core/error.hpp>
#include <volccd/simulation/detail/portable_math.hpp>

#include "shell_support.hpp"

namespace volccd::simulation::shell_test {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

/// Hencky's law in plane stress, computed with an eigenvalue solver: the Cauchy stress in the plane of F.
Matrix3d expected_stress(const Material& m, const Eigen::Matrix<double, 3, 2>& f) {
  const Eigen::SelfAdjointEigenSolver<Matrix2d> c(f.transpose() * f);
  const Eigen::Vector2d e = 0.5 * c.eigenvalues().array().log();
  const double nu = m.poisson_ratio, plane = m.youngs_modulus / (1 - nu * nu);
  const Eigen::Vector2d t(plane * (e[0] + nu * e[1]), plane * (e[1] + nu * e[0]));
  const double dilation = (1 - 2 * nu) / m.youngs_modulus * (t[0] + t[1]);
  Matrix3d out = Matrix3d::Zero();
  for (int k = 0; k < 2; ++k) {
    const Vec3 axis = (f * c.eigenvectors().col(k)).normalized();
    out += t[k] * axis * axis.transpose();
  }
  return out / (1 + dilation);
}

TEST(ShellPatch, HomogeneousStrainOfAnIrregularSheet) {
  Material rubber = steel();
  rubber.youngs_modulus = 1e6;
  for (const double size : {0.001, 0.1, 0.9}) {
    Loop loop(sheet(5, 4, 0.1, 0.12, rubber, 0.01, 0.25));
    Eigen::Matrix<double, 3, 2> f = Eigen::Matrix<double, 3, 2>::Identity();
    f += size * (Eigen::Matrix<double, 3, 2>() << 0.9, 0.3, -0.1, 0.4, 0, 0).finished();
    f = (some_rotation() * f).eval();
    for (Vec3& x : loop.x) x = f * x.head<2>() + Vec3(3, 4, 5);
    loop.compute(0);
    const Matrix3d expected = expected_stress(rubber, f);
    for (const VertexStress& s : loop.stress()) {
      EXPECT_LT((s.stress / s.volume - expected).norm(), 1e-10 * expected.norm() + 1e-8);
    }
    double outer = 0, inner = 0;
    for (Index j = 0; j <= 4; ++j) {
      for (Index i = 0; i <= 5; ++i) {
        const bool inside = i > 0 && j > 0 && i < 5 && j < 4;
        (inside ? inner : outer) = std::max(inside ? inner : outer, loop.force[j * 6 + i].norm());
      }
    }
    EXPECT_GT(outer, 1e-3 * expected.norm() * 0.01 * 0.1);
    EXPECT_LT(inner, 1e-10 * rubber.youngs_modulus * 0.01 * 0.1);
  }
}

TEST(ShellForces, MassIsThatOfAllParts) {
  Model model = sheet(3, 2, 0.5, 0.5, steel(), 0.01);
  model.bodies.push_back(model.bodies[0]);
  model.bodies[1].rigid = true;
  add_vertices(model, {{9, 9, 9}});
  add_triangle(model, 0, 1, model.mesh.vertex_count() - 1, 1);
  const double area = 0.5 * (model.positions[1] - model.positions[0]).cross(Vec3(9, 9, 9) - model.positions[0]).norm();
  Loop loop(model);
  double sum = 0;
  for (const double m : loop.mass) sum += m;
  EXPECT_NEAR(sum, 7800 * 0.01 * (1.5 + area), 1e-9 * sum);
  EXPECT_EQ(loop.shells->triangle_count(), 12u);
}

TEST(ShellForces, NoNetForceOrMoment) {
  Random random(3);
  for (Model model : {sheet(6, 5, 0.1, 0.1, yielding_steel(), 0.004, 0.2), joint(yielding_steel(), 0.02)}) {
    Loop loop(std::move(model));
    for (Vec3& x : loop.x) x = some_rotation() * x + random_vector(random, 0.02);
    for (Vec3& v : loop.v) v = random_vector(random, 30);
    loop.compute(1e-5);
    Vec3 net = Vec3::Zero(), moment = Vec3::Zero();
    double scale = 0;
    for (std::size_t i = 0; i < loop.x.size(); ++i) {
      net += loop.force[i];
      moment += loop.x[i].cross(loop.force[i]);
      scale += loop.force[i].norm();
    }
    EXPECT_GT(loop.shells->plastic_work(), 0);
    EXPECT_LT(net.norm(), 1e-13 * scale);
    EXPECT_LT(moment.norm(), 1e-13 * scale);
  }
}

TEST(ShellForces, AreMinusTheGradientOfTheEnergy) {
  Random random(4);
  Material soft = steel();
  soft.youngs_modulus = 1e6;
  for (Model model : {sheet(3, 3, 0.1, 0.1, soft, 0.01, 0.2), joint(soft, 0.1)}) {
    // In the third case, elastic stretches are outside the range of the logarithm.
    const std::pair<double, Vec3> cases[] = {{0.002, {1, 1, 1}}, {0.02, {1, 1, 1}}, {0.001, {6, 0.15, 2}}};
    for (const auto& [size, stretch] : cases) {
      Loop loop(model);
      for (Vec3& x : loop.x) x = x.cwiseProduct(stretch);
      const double edge = (model.positions[1] - model.positions[0]).norm();
      for (Vec3& x : loop.x) x += random_vector(random, size * 10 * edge);
      loop.compute(0);
      const std::vector<Vec3> force = loop.force;
      const double scale = loop.greatest_force(), h = 1e-6 * edge;
      for (std::size_t i = 0; i < loop.x.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          const double at = loop.x[i][k];
          loop.x[i][k] = at + h;
          loop.compute(0);
          const double up = loop.shells->elastic_energy();
          loop.x[i][k] = at - h;
          loop.compute(0);
          const double down = loop.shells->elastic_energy();
          loop.x[i][k] = at;
          ASSERT_NEAR(force[i][k], (down - up) / (2 * h), 2e-6 * scale) << i << " " << k;
        }
      }
    }
  }
}

TEST(ShellForces, RigidMotionOfAFoldedSheetGivesNone) {
  Model model = sheet(5, 5, 0.1, 0.1, steel(), 0.002, 0.2);
  Random random(5);
  for (Vec3& x : model.positions) x += Vec3(0, 0, random.uniform(-0.05, 0.05));
  Loop loop(model);
  loop.compute(0);
  EXPECT_LT(loop.greatest_force(), 1e-11 * 2e11 * 0.002 * 0.1);
  for (Vec3& x : loop.x) x = some_rotation() * x + Vec3(1, 2, 3);
  loop.compute(0);
  EXPECT_LT(loop.greatest_force(), 1e-11 * 2e11 * 0.002 * 0.1);
  EXPECT_LT(loop.shells->elastic_energy(), 1e-12 * 2e11 * 0.002 * 0.25);
}

TEST(ShellForces, KeepEnergyAtNearlyTheStableStep) {
  for (const double thickness : {0.001, 0.05}) {
    Loop loop(sheet(6, 6, 0.1, 0.1, steel(), thickness, 0.2));
    Random random(6);
    for (Vec3& v : loop.v) v = random_vector(random, 1);
    const double start = loop.kinetic_energy();
    loop.compute(0);
    loop.run(3000, 0.97 * loop.shells->stable_step());
    const double numerical = loop.shells->numerical_work();
    const double end = loop.kinetic_energy() + loop.shells->elastic_energy();
    EXPECT_GT(numerical, 0.05 * start);
    // The kinetic energy is that of half a step earlier, and high modes are damped explicitly.
    EXPECT_NEAR(end + numerical, start, 0.06 * start);
  }
}

TEST(ShellForces, StableStepIsCloseToTheLimit) {
  Loop loop(sheet(6, 6, 0.1, 0.1, steel(), 0.001));
  Random random(6);
  for (Vec3& v : loop.v) v = random_vector(random, 1e-6);
  loop.compute(0);
  const double start = loop.kinetic_energy();
  loop.run(400, 1.6 * loop.shells->stable_step());
  EXPECT_GT(loop.kinetic_energy(), 100 * start);
}

TEST(ShellForces, WaveInAStripHasTheSpeedOfABar) {
  constexpr Index cells = 240;
  const double a = 0.01, speed = std::sqrt(2e11 / 7800);
  Loop loop(sheet(cells, 1, a, a, steel(), 0.001));
  // A smooth wave of 40 cells length that moves to the right: strain = -v / c.
  for (Index j = 0; j < 2; ++j) {
    double shift = 0;
    for (Index i = 0; i <= cells; ++i) {
      const double s = (i - 10.0) / 40, v = s > 0 && s < 1 ? std::pow(std::sin(3.141592653589793 * s), 2) : 0;
      loop.v[j * (cells + 1) + i].x() = v;
      loop.x[j * (cells + 1) + i].x() += shift;
      shift -= v / speed * a;
    }
  }
  const double travel = 150 * a / speed;
  const int steps = static_cast<int>(std::ceil(travel / (0.5 * loop.shells->stable_step())));
  loop.compute(0);
  loop.run(steps, travel / steps);
  double sum = 0, centre = 0;
  for (Index i = 0; i <= cells; ++i) {
    const double v = std::max(loop.v[i].x(), 0.2) - 0.2;
    sum += v;
    centre += v * i;
  }
  EXPECT_NEAR(centre / sum, 10 + 20 + 150, 1.5);  // 1 %
}

/// Stretches a triangle along x; the strain across follows from uniaxial stress with `stress(strain)`.
void pull(Loop& loop, const std::vector<Vec3>& rest, double strain, double stress) {
  const double elastic = stress / 2e11, across = -0.3 * elastic - 0.5 * (strain - elastic);
  for (std::size_t i = 0; i < loop.x.size(); ++i)
    loop.x[i] = some_rotation() * Vec3(rest[i].x() * std::exp(strain), rest[i].y() * std::exp(across), 0);
}

TEST(ShellPlasticity, UniaxialPullFollowsTheCurve) {
  const Material m = yielding_steel();
  const Model model = sheet(2, 2, 0.1, 0.1, m, 0.01, 0.2);
  Loop loop(model);
  const Vec3 axis = some_rotation().col(0);
  double work = 0;
  for (int k = 1; k <= 400; ++k) {
    const double strain = 0.0005 * k;
    const double plastic = std::max(0.0, (strain - m.yield_stress / 2e11) / (1 + m.hardening_modulus / 2e11));
    const double stress = 2e11 * (strain - plastic);
    pull(loop, model.positions, strain, stress);
    loop.compute(1e-4);
    work = (m.yield_stress + 0.5 * m.hardening_modulus * plastic) * plastic * 0.01 * 0.04;
    for (const VertexStress& s : loop.stress()) {
      const Matrix3d mean = s.stress / s.volume;
      const double dilation = 0.4 / 2e11 * stress;
      ASSERT_LT((mean * (1 + dilation) - stress * axis * axis.transpose()).norm(), 1e-7 * stress) << k;
      ASSERT_NEAR(s.plastic_strain / s.volume, plastic, 1e-9);
    }
  }
  EXPECT_NEAR(loop.shells->plastic_work(), work, 1e-6 * work);
  // The elastic strain is reversed, so that no stress remains.
  const double stress = m.yield_stress + m.hardening_modulus * ((0.2 - m.yield_stress / 2e11) / (1 + 1e9 / 2e11));
  const double plastic = 0.2 - stress / 2e11;
  for (std::size_t i = 0; i < loop.x.size(); ++i)
    loop.x[i] = {model.positions[i].x() * std::exp(plastic), model.positions[i].y() * std::exp(-plastic / 2), 0};
  loop.compute(1e-4);
  EXPECT_LT(loop.greatest_force(), 1e-6 * 3e8 * 0.01 * 0.1);
}

TEST(ShellPlasticity, YieldRisesWithTheRate) {
  Material m = yielding_steel();
  m.hardening_modulus = 0;
  m.rate_factor = 0.05;
  m.reference_rate = 2;
  const Model model = sheet(1, 1, 0.1, 0.1, m, 0.01);
  for (const double rate : {0.5, 2.0, 200.0, 20000.0}) {
    Loop loop(model);
    const double expected = 3e8 * (1 + 0.05 * std::log(std::max(1.0, rate / 2)));
    for (int k = 1; k <= 200; ++k) {
      const double strain = 0.0001 * k;
      pull(loop, model.positions, strain, std::min(2e11 * strain, expected));
      loop.compute(0.0001 / rate);
    }
    const VertexStress s = loop.stress()[0];
    const Vec3 axis = some_rotation().col(0);
    EXPECT_NEAR(axis.dot(s.stress * axis) / s.volume, expected, 2e-3 * expected) << rate;
  }
}

TEST(ShellPlasticity, AnyLoadEndsOnTheYieldSurface) {
  Random random(8);
  for (int k = 0; k < 300; ++k) {
    Loop loop(sheet(1, 1, 0.1, 0.1, yielding_steel(), 0.01));
    Matrix3d f = Matrix3d::Identity();
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) f(i, j) += random.uniform(-0.1, 0.1);
    for (Vec3& x : loop.x) x = f * x;
    loop.compute(1e-5);
    const VertexStress s = loop.stress()[0];
    const Matrix3d t = s.stress / (0.01 * 0.005 * (s.volume > 0.01 * 0.0075 ? 2 : 1));  // Kirchhoff; corners of 1 or 2
    const Matrix3d deviator = t - t.trace() / 3 * Matrix3d::Identity();
    const double equivalent = std::sqrt(1.5) * deviator.norm(), strain = s.plastic_strain / s.volume;
    ASSERT_GT(strain, 0);
    ASSERT_NEAR(equivalent, 3e8 + 1e9 * strain, 1e-6 * 3e8);
  }
}

TEST(ShellForces, DegenerateShapesGiveFiniteForces) {
  for (const Material& m : {steel(), yielding_steel()}) {
    const Model model = sheet(3, 3, 0.1, 0.1, m, 0.004, 0.1);
    const std::vector<std::function<Vec3(const Vec3&)>> shapes = {
        [](const Vec3&) { return Vec3(1, 1, 1); },
        [](const Vec3& x) { return Vec3(x.x(), 0, 0); },
        [](const Vec3& x) { return Vec3(-x.x(), x.y() * 1e-9, 0); },
        [](const Vec3& x) { return Vec3(x.x() * 1e-160, x.y() * 1e-160, 0); },
        [](const Vec3& x) { return Vec3(x * 1e6); },
    };
    Loop loop(model);
    for (int k = 0; k < 50; ++k) {
      for (const auto& shape : shapes) {
        for (std::size_t i = 0; i < loop.x.size(); ++i) loop.x[i] = shape(model.positions[i]);
        loop.compute(1e-6);
        for (const Vec3& f : loop.force) ASSERT_TRUE(f.allFinite());
        for (const VertexStress& s : loop.stress()) ASSERT_TRUE(s.stress.allFinite() && std::isfinite(s.volume));
        ASSERT_GT(loop.shells->stable_step(), 0.01 * ShellForces(model).stable_step());
        ASSERT_TRUE(std::isfinite(loop.shells->elastic_energy() + loop.shells->plastic_work()));
      }
    }
    loop.x = model.positions;
    loop.x[5].x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(loop.compute(1e-6), Error);
  }
}

TEST(ShellForces, TriangleWithoutAreaAtRestCountsForNothing) {
  Model model = sheet(1, 1, 0.1, 0.1, steel(), 0.01);
  add_vertices(model, {{0.05, 0, 0}});
  add_triangle(model, 0, 1, 4);
  Loop loop(model);
  EXPECT_EQ(loop.mass[4], 0);
  loop.x[4].z() = 1;
  loop.compute(1e-6);
  EXPECT_EQ(loop.greatest_force() < 1e-3, true);
}

TEST(ShellForces, RefuseWhatIsNotPossible) {
  const Model good = sheet(1, 1, 0.1, 0.1, steel(), 0.01);
  const auto refused = [&](const std::function<void(Model&)>& spoil) {
    Model model = good;
    spoil(model);
    EXPECT_THROW(ShellForces{model}, InputError);
  };
  refused([](Model& m) { m.bodies[0].thickness = 0; });
  refused([](Model& m) { m.bodies[0].material.youngs_modulus = -1; });
  refused([](Model& m) { m.bodies[0].material.poisson_ratio = 0.6; });
  refused([](Model& m) { m.bodies[0].material.density = std::nan(""); });
  refused([](Model& m) { m.bodies.clear(); });
  refused([](Model& m) { m.positions[0].x() = std::nan(""); });
  refused([](Model& m) { m.mesh.add_element({.type = ElementType::quad, .vertices = {0, 1, 3, 2}, .id = 77}); });
}

TEST(PortableMath, AgreesWithTheLibrary) {
  Random random(9);
  for (int k = 0; k < 20000; ++k) {
    const double x = std::exp(random.uniform(-20, 20)), e = random.uniform(-30, 30), l = std::log(x);
    ASSERT_NEAR(detail::portable_log(x), l, 1e-15 * std::max(1.0, std::fabs(l)));
    ASSERT_NEAR(detail::portable_exp(e), std::exp(e), 2e-15 * std::exp(e));
    const double a = random.uniform(-1, 1), b = random.uniform(-1, 1) * (k % 3 == 0 ? 1e-8 : 1);
    ASSERT_NEAR(detail::portable_atan2(a, b), std::atan2(a, b), 1e-15);
    ASSERT_NEAR(detail::portable_atan2(b, a), std::atan2(b, a), 1e-15);
  }
}

}  // namespace
}  // namespace volccd::simulation::shell_test
