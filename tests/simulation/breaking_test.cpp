// Hexahedra that break in two: where and along which plane they break, and what does not change.
#include <sstream>

#include <gtest/gtest.h>

#include <volccd/simulation/topology/element_breaking.hpp>

#include "edit_checks.hpp"
#include "simulation_models.hpp"

namespace volccd::simulation {
namespace {

std::vector<Body> breakable(double strain = 0.5) {
  Body body;
  body.material.breaking_strain = strain;
  return {body};
}

std::vector<VertexStress> drawn(std::size_t vertices, const Vec3& direction, double strain = 0.6) {
  const Vec3 d = direction.normalized();
  return std::vector<VertexStress>(vertices, VertexStress{2 * 10 * d * d.transpose(), 2 * strain, 2});
}

TopologyProposal propose(const MovingMesh& body, const Vec3& direction, const std::vector<Body>& bodies = breakable()) {
  return propose_breaking(body.topology, bodies, body.x, drawn(body.x.size(), direction),
                          std::vector<char>(body.x.size(), 0));
}

/// Volume by the divergence theorem over the boundary, triangulated in VTK's order.
double solid_volume(const MovingMesh& body, Index o) {
  constexpr std::size_t kWedge[8][3] = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1},
                                        {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  double six = 0;
  const auto v = body.mesh().vertices(o);
  for (const auto& t : kWedge) six += body.x[v[t[0]]].dot(body.x[v[t[1]]].cross(body.x[v[t[2]]]));
  return six / 6;
}

using Triangle = std::array<Index, 3>;

/// Triangles of the boundary; no triangle may have more than two elements.
std::set<Triangle> surface(const MovingMesh& body) {
  std::set<Triangle> result;
  const Features& features = body.topology.features();
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    EXPECT_LE(features.triangle_elements(f).size(), 2u);
    if (features.triangle_elements(f).size() == 1) result.insert(features.triangle(f));
  }
  return result;
}

TEST(ElementBreaking, CutsAHexahedronAcrossTheTension) {
  // In a cell whose vertices have ascending numbers, the diagonals contain its first vertex.
  const Vec3 normals[] = {Vec3(1, -1, 0), Vec3(0, 1, -1), Vec3(1, 0, -1)};
  for (const Vec3& normal : normals) {
    MovingMesh body(block(ElementType::hexahedron, 1, 1, 1));
    const std::set<Triangle> before = surface(body);
    const TopologyProposal proposal = propose(body, normal + Vec3(0.1, 0.2, 0.1));
    ASSERT_EQ(proposal.edit.added.size(), 2u);
    EXPECT_TRUE(proposal.new_vertices.empty());
    body.apply(proposal);
    EXPECT_EQ(surface(body), before);
    EXPECT_EQ(body.topology.features().triangle_count(), 14u) << "and the plane's two";
    for (Index o : body.elements()) {
      EXPECT_NEAR(solid_volume(body, o), 0.5, 1e-15);
      double min = 1, max = -1;
      for (Index v : body.mesh().vertices(o)) {
        const double at = normal.dot(body.x[v]);
        min = std::min(min, at), max = std::max(max, at);
      }
      EXPECT_TRUE(min == 0 || max == 0) << "on one side of the plane";
    }
    EXPECT_TRUE(propose(body, normal).empty()) << "a wedge does not break";
  }
}

TEST(ElementBreaking, LeavesAloneWhatCannotBreak) {
  const Vec3 pull(1, -1, 0);
  MovingMesh body(block(ElementType::hexahedron, 1, 1, 1));
  EXPECT_FALSE(propose(body, pull).empty());
  EXPECT_TRUE(propose(body, Vec3(1, 1, 0)).empty()) << "the surface is not triangulated along that plane";
  EXPECT_TRUE(propose(body, Vec3(1, 0.1, 0.1)).empty()) << "across no diagonal";
  EXPECT_TRUE(propose(body, pull, breakable(0.7)).empty()) << "not drawn so far";
  EXPECT_TRUE(propose(body, pull, breakable(kNever)).empty());
  std::vector<Body> rigid = breakable();
  rigid[0].rigid = true;
  EXPECT_TRUE(propose(body, pull, rigid).empty());

  std::vector<VertexStress> stress = drawn(body.x.size(), pull);
  std::vector<char> pressed(body.x.size(), 0);
  pressed[5] = 1;
  EXPECT_TRUE(propose_breaking(body.topology, breakable(), body.x, stress, pressed).empty());
  pressed[5] = 0;
  for (VertexStress& s : stress) s.stress.diagonal() -= Vec3(0, 0, 21);
  EXPECT_TRUE(propose_breaking(body.topology, breakable(), body.x, stress, pressed).empty())
      << "more pressed than drawn";

  body.x[1] = Vec3(0.6, 0.4, 0);  // near the plane
  body.x[5] = Vec3(0.6, 0.4, 1);
  EXPECT_TRUE(propose(body, pull).empty()) << "one piece would be thin";
  const MovingMesh inside(block(ElementType::hexahedron, 3, 3, 3));
  for (const ElementSpec& piece : propose(inside, pull).edit.added)
    EXPECT_NE(piece.id, 13) << "faces inside are not divided";
}

/// With any numbering, the pieces fill the body, their faces match, and the surface is unchanged.
TEST(ElementBreaking, KeepsTheSurfaceOfAnyBlock) {
  std::size_t broken = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    MovingMesh body(permuted(block(ElementType::hexahedron, 3, 3, 1), seed));
    Random random(seed);
    for (Vec3& x : body.x)
      for (int k = 0; k < 3; ++k) x[k] += random.uniform(-0.1, 0.1);
    const std::set<Triangle> before = surface(body);
    const TopologyProposal proposal =
        propose(body, Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.2, 0.2)));
    broken += proposal.edit.removed.size();
    body.apply(proposal);
    EXPECT_EQ(surface(body), before);
    for (Index o : body.elements())
      if (body.mesh().type(o) == ElementType::wedge) {
        EXPECT_GT(solid_volume(body, o), 0.1);
        EXPECT_LT(solid_volume(body, o), 1);
      }
  }
  EXPECT_GT(broken, 20u);
}

/// A strip of one layer of cells that is stretched along the diagonal of the cells until they break and then separate.
Model drawn_strip() {
  Model model = blocks({{.nx = 3, .ny = 3, .nz = 1}});
  Material& material = model.bodies[0].material;
  material.yield_stress = 2e4;
  material.hardening_modulus = 2e4;
  material.breaking_strain = 0.3;
  material.failure_strain = 0.5;
  const Vec3 along = Vec3(1, -1, 0).normalized();
  for (std::size_t i = 0; i < model.positions.size(); ++i)
    model.velocities[i] = 80 * along.dot(model.positions[i]) * along + Vec3(3, 0, 0);
  return model;
}

/// The steps are far below the stable step, because the accuracy of plastic flow is not tested here.
SimulationOptions small_steps() {
  SimulationOptions options;
  options.max_step = 1e-4;
  return options;
}

TEST(ElementBreaking, WithinTheLoopKeepsMassMomentumAndEnergy) {
  SerialExecutor executor;
  Simulation s(drawn_strip(), small_steps(), executor);
  const Ledger before = s.ledger();
  s.advance_to(0.03);
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GE(counts.breaks, 5u);
  EXPECT_GT(counts.splits, 0u);
  EXPECT_EQ(counts.unresolved, 0u);
  EXPECT_EQ(s.topology().mesh().element_count(), 9 + counts.breaks);
  expect_kept(before, s.ledger(), 0.02);
}

TEST(ElementBreaking, GoesOnBitForBitFromACheckpoint) {
  SerialExecutor executor;
  Simulation s(drawn_strip(), small_steps(), executor);
  std::uint64_t breaks = 0;
  double time = 0;
  while (breaks == 0 && time < 0.03) {
    s.advance_to(time += 0.001);
    breaks = s.drain_counts().breaks;
  }
  ASSERT_GT(breaks, 0u);
  std::stringstream file;
  Archive out(static_cast<std::ostream&>(file));
  s.archive(out);
  Simulation resumed(drawn_strip(), small_steps(), executor);
  Archive in(static_cast<std::istream&>(file));
  resumed.archive(in);
  for (Simulation* one : {&s, &resumed}) one->advance_to(time + 0.005);
  EXPECT_TRUE(std::ranges::equal(s.positions(), resumed.positions()));
  EXPECT_EQ(s.ledger().kinetic, resumed.ledger().kinetic);
}

}  // namespace
}  // namespace volccd::simulation
