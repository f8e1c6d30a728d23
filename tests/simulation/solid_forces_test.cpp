// Internal forces of solids without motion: patch tests, balance, energy, rotations, degenerate shapes, edits.
#include <sstream>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <volccd/core/error.hpp>
#include <volccd/simulation/material.hpp>

#include "solid_support.hpp"

namespace volccd::simulation::test {
namespace {

using Eigen::Matrix3d;

const Matrix3d kStretch = (Matrix3d() << 1.3, 0.2, -0.1, 0.05, 0.8, 0.15, 0.1, -0.2, 1.1).finished();

/// A block of 4 x 4 x 4 soft cells of size 0.1 with a shape at rest and the affine deformation kStretch has forces on
/// its boundary only, and no energy in hourglass springs.
void expect_patch(Loop& loop) {
  const Matrix3d& f = kStretch;
  for (Vec3& x : loop.x) x = f * x + Vec3(5, -3, 2);
  loop.compute(0);
  double boundary = 0, inside = 0;
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    const Vec3 rest = loop.model.positions[i];
    const bool in = rest.minCoeff() > 0.01 && rest.maxCoeff() < 0.39;
    (in ? inside : boundary) = std::max(in ? inside : boundary, loop.force[i].norm());
  }
  EXPECT_GT(boundary, 100);
  EXPECT_LT(inside, 1e-11 * boundary);
  const double mu = shear_modulus(soft()), lambda = lame_lambda(soft()), j = f.determinant();
  const double w = mu / 2 * (f.squaredNorm() - 3) - mu * (j - 1) + (lambda + mu) / 2 * (j - 1) * (j - 1);
  EXPECT_NEAR(loop.forces->elastic_energy(), 0.064 * w, 1e-10 * w);
}

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

/// Deformed positions with random displacements of up to `shake` edges.
void shake(Loop& loop, double edge, double amount, std::uint64_t seed) {
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    loop.x[i] = kStretch * loop.model.positions[i] + amount * edge * noise3(seed, i);
    loop.v[i] = 100 * noise3(seed + 1000, i);
  }
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

// Compares central differences of the stored energy with the force in random directions: in the elastic range, and
// elastically about a state with plastic flow.
void expect_force_of_energy(Loop& loop, double edge, std::uint64_t seed) {
  for (Vec3& v : loop.v) v.setZero();
  loop.compute(0);
  const std::vector<Vec3> x = loop.x, force = loop.force;
  for (std::uint64_t k = 0; k < 5; ++k) {
    const double e = 1e-5 * edge;
    double power = 0, size = 0, energy[2];
    for (int s = 0; s < 2; ++s) {
      for (std::size_t i = 0; i < x.size(); ++i) loop.x[i] = x[i] + (s == 0 ? -e : e) * noise3(seed + k, i);
      loop.compute(0);
      energy[s] = loop.forces->elastic_energy();
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      power += force[i].dot(noise3(seed + k, i));
      size += force[i].norm();
    }
    EXPECT_NEAR((energy[1] - energy[0]) / (2 * e), -power, 1e-6 * size);
  }
  loop.x = x;
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
  stranger.parts.clear();
  EXPECT_THROW(make_solid_forces(stranger), InputError);
  Material rubber = soft();
  rubber.poisson_ratio = 0.5;
  EXPECT_THROW(make_solid_forces(block(Solid::tetrahedra, {1, 1, 1}, 0.1, rubber)), InputError);
  Model wedge = block(Solid::tetrahedra, {1, 1, 1}, 0.1, soft());
  wedge.mesh.add_element({ElementType::wedge, {0, 1, 2, 4, 5, 6}, {}, 0, 99});
  EXPECT_THROW(make_solid_forces(wedge), InputError);
}

TEST(SolidForces, RigidPartsHaveMassOnly) {
  Model model = block(Solid::both, {2, 1, 1}, 0.1, steel());
  model.parts[0].rigid = true;
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

std::vector<Vec3> run_steps(Loop& loop, Executor& executor, int steps, std::uint64_t first = 0) {
  for (int k = 0; k < steps; ++k) {
    shake(loop, 0.1, 0.1, 40 + first + static_cast<std::uint64_t>(k));
    for (Vec3& f : loop.force) f = Vec3(0.1, 0.2, 0.3);
    loop.forces->add_forces(loop.x, loop.v, 1e-6, executor, loop.force);
  }
  return loop.force;
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

// --- edits ---

/// Replaces vertices in elements (slot, from, to), whichever slots the mesh assigns; returns the heritage.
ElementHeritage replace(Mesh& mesh, const std::vector<std::array<Index, 3>>& changes) {
  ElementHeritage heritage;
  std::vector<ElementSpec> specs;
  for (const auto& [slot, from, to] : changes) {
    ElementSpec spec{mesh.type(slot), {mesh.vertices(slot).begin(), mesh.vertices(slot).end()}, {}, 0, 0};
    spec.id = mesh.element_id(slot);
    std::replace(spec.vertices.begin(), spec.vertices.end(), from, to);
    specs.push_back(spec);
    heritage.removed.push_back(slot);
    heritage.parents.push_back(slot);
  }
  for (const auto& change : changes) mesh.remove_element(change[0]);
  for (const ElementSpec& spec : specs) heritage.added.push_back(mesh.add_element(spec));
  return heritage;
}

TEST(SolidForces, SplittingAVertexKeepsTheStress) {
  for (const Solid solid : {Solid::tetrahedra, Solid::hexahedra}) {
    Loop loop(block(solid, {3, 3, 3}, 0.1, steel(), 0.2));
    run_steps(loop, loop.executor, 2);
    loop.compute(0);
    const Index split = 1 + 4 * (1 + 4 * 1);
    const auto stress = loop.stress();
    const std::vector<Vec3> force = loop.force;
    const double plastic = loop.forces->plastic_work(), numerical = loop.forces->numerical_work();
    loop.model.mesh.add_vertices(1);
    const Index copy = loop.model.mesh.vertex_count() - 1;
    std::vector<std::array<Index, 3>> changes;
    for (Index o = 0; o < loop.model.mesh.element_slots(); ++o) {
      const auto vertices = loop.model.mesh.vertices(o);
      if (o % 2 == 0 && std::find(vertices.begin(), vertices.end(), split) != vertices.end()) {
        changes.push_back({o, split, copy});
      }
    }
    ASSERT_GE(changes.size(), 2u);
    const ElementHeritage heritage = replace(loop.model.mesh, changes);
    EXPECT_NE(heritage.added, heritage.parents) << "slots should change hands for this test";
    for (auto* values : {&loop.x, &loop.v, &loop.force, &loop.model.positions, &loop.model.velocities})
      values->push_back((*values)[split]);
    // The reference positions must not matter, because the element has its own shape.
    loop.model.positions[copy] += Vec3(0.01, 0, 0);
    loop.mass.assign(loop.x.size(), 0);
    loop.forces->update(loop.model.mesh, loop.model.positions, loop.x, heritage);
    loop.forces->add_masses(loop.mass);
    for (const bool computed : {false, true}) {
      if (computed) loop.compute(0);
      const auto after = loop.stress();
      EXPECT_LT((after[split].stress + after[copy].stress - stress[split].stress).norm(),
                1e-12 * stress[split].stress.norm());
      EXPECT_LT((after[0].stress - stress[0].stress).norm(), 1e-12 * stress[0].stress.norm());
      EXPECT_NEAR(after[split].plastic_strain + after[copy].plastic_strain, stress[split].plastic_strain, 1e-15);
    }
    EXPECT_LT((loop.force[split] + loop.force[copy] - force[split]).norm(), 1e-12 * largest(force));
    EXPECT_GT(loop.force[copy].norm(), 1e-3 * largest(force));
    EXPECT_NEAR(loop.forces->plastic_work(), plastic, 1e-13 * plastic);
    EXPECT_NEAR(loop.forces->numerical_work(), numerical, 1e-13 * numerical);

    // Reads the archive of an edited table into an object for the edited mesh.
    std::stringstream file;
    Archive out(static_cast<std::ostream&>(file));
    loop.forces->archive(out);
    Loop resumed(loop.model);
    Archive in(static_cast<std::istream&>(file));
    resumed.forces->archive(in);
    EXPECT_EQ(resumed.forces->plastic_work(), loop.forces->plastic_work());
    EXPECT_EQ(resumed.forces->numerical_work(), loop.forces->numerical_work());
    run_steps(loop, loop.executor, 1);
    EXPECT_EQ(run_steps(resumed, resumed.executor, 1), loop.force);
  }
}

TEST(SolidForces, ResumeBetweenEditsBitForBit) {
  // Sums at a vertex depend on the order of its elements, and this on the rows that removed elements left.
  Loop loop(block(Solid::tetrahedra, {2, 2, 2}, 0.1, steel(), 0.1));
  run_steps(loop, loop.executor, 1);
  Mesh& mesh = loop.model.mesh;
  ElementHeritage removal{{2, 9, 17, 30, 31, 45}, {}, {}}, addition;
  std::vector<ElementSpec> specs;
  for (const Index o : removal.removed) {
    specs.push_back({ElementType::tetrahedron, {mesh.vertices(o).begin(), mesh.vertices(o).end()}, {}, 0, 100 + o});
  }
  for (const Index o : removal.removed) mesh.remove_element(o);
  loop.forces->update(mesh, loop.model.positions, loop.x, removal);
  std::stringstream file;
  Archive out(static_cast<std::ostream&>(file));
  loop.forces->archive(out);
  Loop resumed(loop.model);
  Archive in(static_cast<std::istream&>(file));
  resumed.forces->archive(in);
  for (const ElementSpec& spec : specs) {
    addition.added.push_back(mesh.add_element(spec));
    addition.parents.push_back(kNone);
  }
  for (Loop* l : {&loop, &resumed}) l->forces->update(mesh, loop.model.positions, loop.x, addition);
  EXPECT_EQ(run_steps(resumed, resumed.executor, 2), run_steps(loop, loop.executor, 2));
}

TEST(SolidForces, PiecesOfATetrahedronHaveItsStress) {
  Loop loop(block(Solid::tetrahedra, {1, 1, 1}, 0.1, steel()));
  run_steps(loop, loop.executor, 2);
  const auto stress = loop.stress();
  const double energy = loop.forces->elastic_energy(), step = loop.forces->stable_step();
  Mesh& mesh = loop.model.mesh;
  // Tetrahedron 0 is divided at a point of its edge 0-2; its neighbours are ignored here.
  const std::vector<Index> c(mesh.vertices(0).begin(), mesh.vertices(0).end());
  mesh.add_vertices(1);
  const Index p = mesh.vertex_count() - 1;
  for (auto* values : {&loop.x, &loop.v, &loop.force, &loop.model.positions, &loop.model.velocities}) {
    values->push_back(0.9 * (*values)[c[0]] + 0.1 * (*values)[c[2]]);
  }
  mesh.remove_element(0);
  ElementHeritage heritage{{0}, {}, {0, 0}};
  heritage.added.push_back(mesh.add_element({ElementType::tetrahedron, {c[0], c[1], p, c[3]}, {}, 0, 100}));
  heritage.added.push_back(mesh.add_element({ElementType::tetrahedron, {p, c[1], c[2], c[3]}, {}, 0, 101}));
  loop.mass.assign(loop.x.size(), 0);
  loop.forces->update(mesh, loop.model.positions, loop.x, heritage);
  loop.forces->add_masses(loop.mass);
  EXPECT_LT(loop.forces->stable_step(), 0.5 * step) << "of the small piece, at once";
  for (const bool computed : {false, true}) {
    if (computed) loop.compute(0);
    const auto after = loop.stress();
    Matrix3d sum = Matrix3d::Zero(), before = Matrix3d::Zero();
    for (const VertexStress& s : after) sum += s.stress;
    for (const VertexStress& s : stress) before += s.stress;
    EXPECT_LT((sum - before).norm(), 1e-10 * before.norm());
    EXPECT_NEAR(loop.forces->elastic_energy(), energy, 1e-10 * energy);
  }
  double mass = 0;
  for (const double m : loop.mass) mass += m;
  EXPECT_NEAR(mass, 7.8, 1e-12);
}

/// Divides every hexahedron into two wedges by the plane through its corners 0, 2, 4 and 6.
void break_all(Loop& loop) {
  Mesh& mesh = loop.model.mesh;
  ElementHeritage heritage;
  std::vector<ElementSpec> specs;
  const Index slots = mesh.element_slots();
  for (Index o = 0; o < slots; ++o) {
    const auto c = mesh.vertices(o);
    specs.push_back({ElementType::wedge, {c[2], c[1], c[0], c[6], c[5], c[4]}, {}, 0, 2 * o + 1000});
    specs.push_back({ElementType::wedge, {c[0], c[3], c[2], c[4], c[7], c[6]}, {}, 0, 2 * o + 1001});
    heritage.removed.push_back(o);
    heritage.parents.insert(heritage.parents.end(), 2, o);
  }
  for (const Index o : heritage.removed) mesh.remove_element(o);
  for (const ElementSpec& spec : specs) heritage.added.push_back(mesh.add_element(spec));
  loop.forces->update(mesh, loop.model.positions, loop.x, heritage);
}

TEST(SolidForces, PiecesOfHexahedraHaveTheirStressAndKeepEachVertexsMass) {
  Loop loop(block(Solid::hexahedra, {3, 3, 3}, 0.1, steel(), 0.2));
  // Without bending within an element, which its pieces do not inherit.
  for (Vec3& x : loop.x) x = kStretch * x;
  loop.compute(1e-6);
  ASSERT_GT(loop.forces->plastic_work(), 0);
  const auto stress = loop.stress();
  const std::vector<double> mass = loop.mass;
  const double energy = loop.forces->elastic_energy(), plastic = loop.forces->plastic_work(),
               step = loop.forces->stable_step();
  break_all(loop);
  EXPECT_LT(loop.forces->stable_step(), step);
  EXPECT_GT(loop.forces->stable_step(), 0.5 * step);
  loop.mass.assign(loop.x.size(), 0);
  loop.forces->add_masses(loop.mass);
  for (std::size_t i = 0; i < mass.size(); ++i) EXPECT_NEAR(loop.mass[i], mass[i], 1e-14 * mass[i]);
  for (const bool computed : {false, true}) {
    if (computed) loop.compute(0);
    const auto after = loop.stress();
    Matrix3d sum = Matrix3d::Zero(), before = Matrix3d::Zero();
    for (const VertexStress& s : after) sum += s.stress;
    for (const VertexStress& s : stress) before += s.stress;
    EXPECT_LT((sum - before).norm(), 1e-3 * before.norm());
    EXPECT_NEAR(loop.forces->elastic_energy(), energy, 0.01 * energy);
    EXPECT_NEAR(loop.forces->plastic_work(), plastic, 1e-13 * plastic);
  }
}

TEST(SolidForces, PiecesOfHexahedraPassThePatchTest) {
  Loop loop(block(Solid::hexahedra, {4, 4, 4}, 0.1, soft(), 0.15));
  loop.compute(0);
  break_all(loop);
  expect_patch(loop);
  expect_force_of_energy(loop, 0.1, 15);
  // Every motion of a free piece except for rigid-body motions costs energy; otherwise the piece would collapse.
  Loop one(block(Solid::hexahedra, {1, 1, 1}, 0.1, soft()));
  one.compute(0);
  break_all(one);
  for (std::uint64_t k = 0; k < 20; ++k) {
    for (std::size_t i = 0; i < 8; ++i) one.x[i] = one.model.positions[i] + 1e-3 * noise3(k, i);
    one.compute(0);
    EXPECT_GT(one.forces->elastic_energy(), 1e-4);
  }
}

TEST(SolidForces, WhatGoesTakesItsForcesAlong) {
  Loop loop(block(Solid::both, {2, 1, 1}, 0.1, steel()));
  run_steps(loop, loop.executor, 1);
  const double plastic = loop.forces->plastic_work();
  ElementHeritage heritage;
  for (Index o = 0; o < loop.model.mesh.element_slots(); ++o) heritage.removed.push_back(o);
  for (const Index o : heritage.removed) loop.model.mesh.remove_element(o);
  loop.forces->update(loop.model.mesh, loop.model.positions, loop.x, heritage);
  loop.compute(1e-6);
  EXPECT_EQ(largest(loop.force), 0);
  EXPECT_EQ(loop.forces->elastic_energy(), 0);
  EXPECT_NEAR(loop.forces->plastic_work(), plastic, 1e-13 * plastic);
  EXPECT_EQ(loop.forces->stable_step(), kNever);
  // A new element without a parent, in a slot that was in use before.
  heritage = {{}, {loop.model.mesh.add_element({ElementType::tetrahedron, {0, 1, 4, 6}, {}, 0, 500})}, {kNone}};
  loop.forces->update(loop.model.mesh, loop.model.positions, loop.x, heritage);
  loop.x = loop.model.positions;
  for (Vec3& v : loop.v) v.setZero();
  loop.compute(1e-6);
  EXPECT_LT(largest(loop.force), 1e-6);
  EXPECT_LT(loop.forces->stable_step(), 1e-3);
}

}  // namespace
}  // namespace volccd::simulation::test
