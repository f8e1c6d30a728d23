// Internal forces of solids when the mesh changes: splits, cuts into pieces, elements that go.
#include <sstream>

#include <gtest/gtest.h>

#include "solid_checks.hpp"

namespace volccd::simulation::test {
namespace {

using Eigen::Matrix3d;

/// Replaces vertices in elements (slot, from, to), whichever slots the mesh assigns; returns the heritage.
ElementHeritage replace(Mesh& mesh, const std::vector<std::array<Index, 3>>& changes) {
  ElementHeritage heritage;
  std::vector<ElementSpec> specs;
  for (const auto& [slot, from, to] : changes) {
    ElementSpec spec{.type = mesh.type(slot), .vertices = {mesh.vertices(slot).begin(), mesh.vertices(slot).end()}};
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

TEST(SolidEdits, SplittingAVertexKeepsTheStress) {
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

TEST(SolidEdits, ResumeBetweenEditsBitForBit) {
  // Sums at a vertex depend on the order of its elements, and this on the rows that removed elements left.
  Loop loop(block(Solid::tetrahedra, {2, 2, 2}, 0.1, steel(), 0.1));
  run_steps(loop, loop.executor, 1);
  Mesh& mesh = loop.model.mesh;
  ElementHeritage removal{{2, 9, 17, 30, 31, 45}, {}, {}}, addition;
  std::vector<ElementSpec> specs;
  for (const Index o : removal.removed) {
    specs.push_back({.type = ElementType::tetrahedron,
                     .vertices = {mesh.vertices(o).begin(), mesh.vertices(o).end()},
                     .id = 100 + o});
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

TEST(SolidEdits, PiecesOfATetrahedronHaveItsStress) {
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
  heritage.added.push_back(
      mesh.add_element({.type = ElementType::tetrahedron, .vertices = {c[0], c[1], p, c[3]}, .id = 100}));
  heritage.added.push_back(
      mesh.add_element({.type = ElementType::tetrahedron, .vertices = {p, c[1], c[2], c[3]}, .id = 101}));
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
    specs.push_back({.type = ElementType::wedge, .vertices = {c[2], c[1], c[0], c[6], c[5], c[4]}, .id = 2 * o + 1000});
    specs.push_back({.type = ElementType::wedge, .vertices = {c[0], c[3], c[2], c[4], c[7], c[6]}, .id = 2 * o + 1001});
    heritage.removed.push_back(o);
    heritage.parents.insert(heritage.parents.end(), 2, o);
  }
  for (const Index o : heritage.removed) mesh.remove_element(o);
  for (const ElementSpec& spec : specs) heritage.added.push_back(mesh.add_element(spec));
  loop.forces->update(mesh, loop.model.positions, loop.x, heritage);
}

TEST(SolidEdits, PiecesOfHexahedraHaveTheirStressAndKeepEachVertexsMass) {
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

TEST(SolidEdits, PiecesOfHexahedraPassThePatchTest) {
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

TEST(SolidEdits, WhatGoesTakesItsForcesAlong) {
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
  heritage = {{},
              {loop.model.mesh.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 4, 6}, .id = 500})},
              {kNone}};
  loop.forces->update(loop.model.mesh, loop.model.positions, loop.x, heritage);
  loop.x = loop.model.positions;
  for (Vec3& v : loop.v) v.setZero();
  loop.compute(1e-6);
  EXPECT_LT(largest(loop.force), 1e-6);
  EXPECT_LT(loop.forces->stable_step(), 1e-3);
}

}  // namespace
}  // namespace volccd::simulation::test
