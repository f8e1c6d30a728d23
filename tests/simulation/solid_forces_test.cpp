// Internal forces of solids without motion: patch tests, balance, energy, rotations, degenerate shapes.
#include <sstream>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <volccd/core/error.hpp>
#include <volccd/simulation/elements/material.hpp>

#include "solid_checks.hpp"

namespace volccd::simulation::test {
namespace {

using Eigen::Matrix3d;

class SolidPatch : public testing::TestWithParam<Solid> {};
INSTANTIATE_TEST_SUITE_P(Types, SolidPatch, testing::Values(Solid::tetrahedra, Solid::hexahedra));

TEST_P(SolidPatch, AffineDeformationOfAnIrregularBlock) {
  Loop loop(block(GetParam(), {4, 4, 4}, 0.1, soft(), 0.15));
  expect_patch(loop);
  const Matrix3d& f = kStretch;
  const double mu = shear_modulus(soft()), lambda = lame_lambda(soft()), j = f.determinant();
  const Matrix3d expected = mu / j * f * f.transpose() + ((lambda + mu) * (j - 1) - mu) * Matrix3d::Identity();
  for (const VertexStress& s : loop.stress()) {
    EXPECT_LT((s.stress / s.volume - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.norm());
  }
}

TEST_P(SolidPatch, SmallStrainsFollowHooke) {
  Loop loop(block(GetParam(), {2, 2, 2}, 0.1, soft(), 0.15));
  Matrix3d h;
  h << 2, 1, -1, 3, -4, 2, 0, 1, 1;
  h *= 1e-7;
  for (Vec3& x : loop.x) x += h * x;
  loop.compute(0);
  const Matrix3d e = 0.5 * (h + h.transpose());
  const Matrix3d expected = 2 * shear_modulus(soft()) * e + lame_lambda(soft()) * e.trace() * Matrix3d::Identity();
  EXPECT_LT((loop.mean_stress() - expected).norm(), 2e-6 * expected.norm());
}

TEST(SolidForces, FreeBodyIsInBalance) {
  for (const double amount : {0.1, 2.0}) {  // the latter inverts elements
    Loop loop(block(Solid::both, {4, 3, 3}, 0.1, steel(), 0.2));
    shake(loop, 0.1, amount, 3);
    loop.compute(1e-6);
    ASSERT_GT(loop.forces->plastic_work(), 0);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0;
    for (std::size_t i = 0; i < loop.x.size(); ++i) {
      sum += loop.force[i];
      moment += loop.x[i].cross(loop.force[i]);
      size += loop.force[i].norm();
    }
    EXPECT_LT(sum.norm(), 1e-13 * size);
    EXPECT_LT(moment.norm(), 1e-13 * size);
  }
}

TEST(SolidForces, AreTheGradientOfTheEnergy) {
  for (const double amount : {0.05, 0.3, 1.5}) {
    Loop elastic(block(Solid::both, {4, 2, 2}, 0.1, soft(), 0.2));
    shake(elastic, 0.1, amount, 11);
    expect_force_of_energy(elastic, 0.1, 12);
    Loop plastic(block(Solid::both, {4, 2, 2}, 0.1, steel(), 0.2));
    shake(plastic, 0.1, 0.1, 13);
    plastic.compute(1e-6);
    ASSERT_GT(plastic.forces->plastic_work(), 0);
    shake(plastic, 0.1, amount, 13);
    expect_force_of_energy(plastic, 0.1, 14);
  }
}

TEST(SolidForces, RotateWithTheBody) {
  const Matrix3d r = Eigen::AngleAxisd(2.3, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Loop straight(block(Solid::both, {4, 2, 2}, 0.1, steel(), 0.2)), turned(straight.model);
  for (int k = 0; k < 3; ++k) {  // plastic flow, and again from another shape
    shake(straight, 0.1, 0.1, 20 + static_cast<std::uint64_t>(k));
    for (std::size_t i = 0; i < straight.x.size(); ++i) {
      // A different rotation each time, so that nothing is remembered from the last one.
      turned.x[i] = (k == 1 ? Matrix3d(r.transpose()) : r) * straight.x[i];
      turned.v[i] = (k == 1 ? Matrix3d(r.transpose()) : r) * straight.v[i];
    }
    straight.compute(1e-6);
    turned.compute(1e-6);
  }
  ASSERT_GT(straight.forces->plastic_work(), 0);
  const double size = largest(straight.force);
  const auto s = straight.stress(), t = turned.stress();
  for (std::size_t i = 0; i < straight.x.size(); ++i) {
    EXPECT_LT((r * straight.force[i] - turned.force[i]).norm(), 1e-9 * size);
    EXPECT_LT((r * s[i].stress * r.transpose() - t[i].stress).norm(), 1e-9 * s[i].stress.norm());
  }
  EXPECT_NEAR(straight.forces->elastic_energy(), turned.forces->elastic_energy(),
              1e-9 * straight.forces->elastic_energy());
}

TEST(SolidForces, HourglassModesOfACubeAreThoseOfBending) {
  const double edge = 0.2, e = soft().youngs_modulus, q = 1e-3;
  for (int mode = 0; mode < 4; ++mode) {
    for (int axis = 0; axis < 3; ++axis) {
      Loop loop(block(Solid::hexahedra, {1, 1, 1}, edge, soft()));
      for (Vec3& x : loop.x) {
        const Vec3 xi = x / (0.5 * edge) - Vec3::Ones();
        x[axis] += q * (mode == 3 ? xi.prod() : xi[(mode + 1) % 3] * xi[(mode + 2) % 3]);
      }
      const std::vector<Vec3> shift = [&] {
        std::vector<Vec3> d = loop.x;
        for (std::size_t i = 0; i < d.size(); ++i) d[i] -= loop.model.positions[i];
        return d;
      }();
      loop.compute(0);
      // The strain is q / (edge / 2) at the faces, and decreases to 0 in the middle.
      const double bending = 0.5 * e * std::pow(edge, 3) * std::pow(q / (0.5 * edge), 2) / (mode == 3 ? 9 : 3);
      EXPECT_NEAR(loop.forces->elastic_energy(), bending, 1e-9 * bending);
      for (std::size_t i = 0; i < 8; ++i) EXPECT_LT(loop.force[i].dot(shift[i]), 0);
    }
  }
}

TEST(SolidForces, AnyShapeHasFiniteForces) {
  for (const Material& material : {soft(), steel()}) {
    for (const Solid solid : {Solid::tetrahedra, Solid::hexahedra}) {
      Loop loop(block(solid, {1, 1, 1}, 0.1, material));
      for (std::uint64_t k = 0; k < 300; ++k) {
        const double size = std::pow(10.0, 3 * noise(1, k) - 1);
        for (std::size_t i = 0; i < loop.x.size(); ++i) {
          loop.x[i] = size * noise3(k, i);
          if (k % 5 == 1) loop.x[i].setZero();                                        // a point
          if (k % 5 == 2) loop.x[i][2] = 0;                                           // a plane
          if (k % 5 == 3) loop.x[i] = -loop.model.positions[i];                       // inverted
          if (k % 5 == 4) loop.x[i] = loop.model.positions[i] + 1e-4 * noise3(k, i);  // and back
          loop.v[i] = 1e3 * noise3(k + 1, i);
        }
        loop.compute(1e-6);
        for (const Vec3& f : loop.force) ASSERT_TRUE(f.allFinite());
        ASSERT_GT(loop.forces->stable_step(), 0);
        ASSERT_TRUE(std::isfinite(loop.forces->elastic_energy() + loop.forces->plastic_work()));
        for (const VertexStress& s : loop.stress()) ASSERT_TRUE(s.stress.allFinite() && s.volume > 0);
      }
    }
  }
}

TEST(SolidForces, NotFiniteIsAnError) {
  Loop loop(block(Solid::both, {2, 1, 1}, 0.1, steel()));
  loop.x[3][1] = std::nan("");
  EXPECT_THROW(loop.compute(1e-6), Error);
  loop.x[3][1] = 1e200;
  EXPECT_THROW(loop.compute(1e-6), Error);
}

TEST(SolidForces, RefuseWhatTheyCannotHold) {
  Model flat = block(Solid::hexahedra, {1, 1, 1}, 0.1, soft());
  for (Vec3& x : flat.positions) x[1] = 0;
  EXPECT_THROW(make_solid_forces(flat), InputError);
  Model stranger = block(Solid::tetrahedra, {1, 1, 1}, 0.1, soft());
  stranger.bodies.clear();
  EXPECT_THROW(make_solid_forces(stranger), InputError);
  Material rubber = soft();
  rubber.poisson_ratio = 0.5;
  EXPECT_THROW(make_solid_forces(block(Solid::tetrahedra, {1, 1, 1}, 0.1, rubber)), InputError);
  Model wedge = block(Solid::tetrahedra, {1, 1, 1}, 0.1, soft());
  wedge.mesh.add_element({.type = ElementType::wedge, .vertices = {0, 1, 2, 4, 5, 6}, .id = 99});
  EXPECT_THROW(make_solid_forces(wedge), InputError);
}

TEST(SolidForces, RigidPartsHaveMassOnly) {
  Model model = block(Solid::both, {2, 1, 1}, 0.1, steel());
  model.bodies[0].rigid = true;
  Loop loop(model);
  double mass = 0;
  for (const double m : loop.mass) mass += m;
  EXPECT_NEAR(mass, 0.002 * 7800, 1e-9);
  shake(loop, 0.1, 0.3, 5);
  loop.compute(1e-6);
  EXPECT_EQ(largest(loop.force), 0);
  loop.force[0] = Vec3(1, 2, 3);  // existing values are kept
  loop.forces->add_forces(loop.x, loop.v, 1e-6, loop.executor, loop.force);
  EXPECT_EQ(loop.force[0], Vec3(1, 2, 3));
  EXPECT_EQ(loop.forces->stable_step(), kNever);
  EXPECT_EQ(loop.stress()[0].volume, 0);
}

TEST(SolidForcesThreads, AreTheSameBitForBit) {
  const Model model = block(Solid::both, {12, 8, 8}, 0.1, steel(), 0.2);
  Loop alone(model);
  const std::vector<Vec3> expected = run_steps(alone, alone.executor, 3);
  for (const unsigned threads : {2u, 3u, 5u}) {
    Loop loop(model);
    const auto executor = make_thread_executor(threads);
    EXPECT_EQ(run_steps(loop, *executor, 3), expected);
    EXPECT_EQ(loop.forces->stable_step(), alone.forces->stable_step());
    EXPECT_EQ(loop.forces->plastic_work(), alone.forces->plastic_work());
    EXPECT_EQ(loop.forces->numerical_work(), alone.forces->numerical_work());
    EXPECT_EQ(loop.forces->elastic_energy(), alone.forces->elastic_energy());
  }
}

TEST(SolidForces, AreTheSameOnEveryProcessor) {
  const Model model = block(Solid::both, {5, 3, 3}, 0.1, steel(), 0.2);
  Loop first(model);
  const std::vector<Vec3> expected = run_steps(first, first.executor, 3);
  ASSERT_GT(first.forces->plastic_work(), 0);
  // All instruction sets, from the widest downwards, and at the end without any.
  for (auto targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().DeInit();
    Loop loop(model);
    EXPECT_EQ(run_steps(loop, loop.executor, 3), expected) << targets;
    EXPECT_EQ(loop.forces->stable_step(), first.forces->stable_step());
    EXPECT_EQ(loop.forces->numerical_work(), first.forces->numerical_work());
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(SolidForces, ArchiveGoesOnBitForBit) {
  Loop first(block(Solid::both, {4, 2, 2}, 0.1, steel(), 0.2)), second(first.model);
  run_steps(first, first.executor, 3);
  std::stringstream file;
  Archive out(static_cast<std::ostream&>(file));
  first.forces->archive(out);
  Archive in(static_cast<std::istream&>(file));
  second.forces->archive(in);
  EXPECT_EQ(second.forces->stable_step(), first.forces->stable_step());
  EXPECT_EQ(second.forces->plastic_work(), first.forces->plastic_work());
  EXPECT_EQ(run_steps(second, second.executor, 2, 3), run_steps(first, first.executor, 2, 3));
  EXPECT_EQ(second.forces->plastic_work(), first.forces->plastic_work());
}

}  // namespace
}  // namespace volccd::simulation::test
