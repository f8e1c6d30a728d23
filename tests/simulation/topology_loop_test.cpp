// Splitting, merging and cutting in the time loop: quantities that the edits must not change, and contacts at new
// surfaces.
#include <gtest/gtest.h>

#include <volccd/simulation/contact/contact_detection.hpp>

#include "edit_checks.hpp"
#include "simulation_models.hpp"

namespace volccd::simulation {
namespace {

/// Number of pieces that are connected by vertices.
std::size_t pieces(const Simulation& s) {
  const Mesh& mesh = s.topology().mesh();
  std::vector<Index> root(mesh.vertex_count());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  std::set<Index> roots;
  for (int pass = 0; pass < 2; ++pass)
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o))
        for (Index v : mesh.vertices(o))
          pass == 0 ? void(root[find(v)] = find(mesh.vertices(o)[0])) : void(roots.insert(find(v)));
  return roots.size();
}

/// Two blocks with a common face, of a material that can merge.
void expect_one_block(double sideways) {
  Model model = blocks({{.nx = 2, .velocity = Vec3(5, 0, 0)}, {.nx = 2, .at = Vec3(0.202, sideways, 0)}});
  for (Body& body : model.bodies) {
    body.material.merging_force = 1;
    body.material.merging_distance = 0.01;
  }
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  const Ledger before = s.ledger();
  EXPECT_EQ(pieces(s), 2u);
  s.advance_to(0.05);
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GE(counts.merges, 2u);
  EXPECT_EQ(counts.unresolved, 0u);
  EXPECT_EQ(pieces(s), 1u);
  EXPECT_GT(s.ledger().topology, 0) << "merging is inelastic";
  expect_kept(before, s.ledger(), 0.02);
  // Once merged, they do not separate: without merging, the first one would stay behind.
  const double gap = mean(s, s.positions(), 1).x() - mean(s, s.positions(), 0).x();
  s.advance_to(0.2);
  EXPECT_NEAR(mean(s, s.positions(), 1).x() - mean(s, s.positions(), 0).x(), gap, 0.02);
}

/// Which vertices merge first depends on roundings of contact times. Slower blocks, of which only two vertices merge,
/// turn against each other, and the energy in them changes by more than merging takes.
TEST(TopologyLoop, BlocksThatHitHardBecomeOne) {
  for (const double sideways : {0.0, 1e-6, 1e-3}) {
    SCOPED_TRACE(sideways);
    expect_one_block(sideways);
  }
}

/// A moving block that is cut through.
TEST(TopologyLoop, CutBlockFliesOnAsTwo) {
  Model model = blocks({{ElementType::tetrahedron, 3, 3, 3, Vec3(0.1, 0.1, 0.1), Vec3::Zero(), Vec3(1, 0, 0)}});
  for (std::size_t i = 0; i < model.positions.size(); ++i)
    model.velocities[i].z() = 2 * (model.positions[i].z() - 0.15);
  model.cuts.push_back({0, Vec3(-0.1, 0.15, 0.163), Vec3::UnitX(), Vec3::UnitZ(), 0, 20, 0.6});
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  const Ledger before = s.ledger();
  const Index elements = s.topology().mesh().element_count();
  s.advance_to(0.05);
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GT(counts.cuts, 1u) << "in steps, as the blade goes";
  EXPECT_GT(s.topology().mesh().element_count(), elements);
  EXPECT_EQ(pieces(s), 2u);
  EXPECT_EQ(counts.unresolved, 0u);
  expect_kept(before, s.ledger(), 0.02);
}

/// After a vertex has split, features nearly touch in all directions. These contacts must not connect the corner of the
/// crack.
TEST(TopologyLoop, CracksOpenFreely) {
  Model model = blocks({{.nx = 6, .ny = 3, .nz = 3}});
  for (std::size_t i = 0; i < model.positions.size(); ++i) {
    const Vec3& x = model.positions[i];
    model.velocities[i] = Vec3(60 * (x.x() - 0.3), 25 * (x.z() - 0.15), 5);
  }
  model.bodies[0].material.failure_stress = 5e4;
  SerialExecutor executor;
  Simulation s(model, {}, executor);
  const Ledger before = s.ledger();
  s.advance_to(0.02);
  const SimulationCounts counts = s.drain_counts();
  EXPECT_GT(counts.splits, 20u);
  EXPECT_EQ(counts.held, 0u);
  EXPECT_EQ(counts.unresolved, 0u);
  expect_kept(before, s.ledger(), 0.02);
}

/// Two hexahedra that were one body and have been separated at a face.
struct Parted {
  Parted() : shape(block(ElementType::hexahedron, 2, 1, 1)), topology(shape.mesh()), x(shape.positions) {
    for (Index v = 0; v < x.size(); ++v) origins.push_back(v);
    TopologyProposal proposal;
    ElementSpec second = element_spec(topology.mesh(), 1);
    for (Index v = 0; v < shape.positions.size(); ++v) {
      if (shape.positions[v].x() != 1) continue;
      replace_vertex(second, v, add_copy(proposal, topology.mesh(), v));
      origins.push_back(v);
    }
    replace_element(proposal, 1, second);
    edit = proposal.edit;
    inherit(proposal, x);
  }
  /// The second element is moved by this vector.
  std::vector<Vec3> moved(const Vec3& by) const {
    std::vector<Vec3> result = x;
    for (Index v : topology.mesh().vertices(topology.mesh().find_element(1))) result[v] += by;
    return result;
  }

  Shape shape;
  Topology topology;
  TopologyEdit edit;
  std::vector<Vec3> x;
  std::vector<Index> origins;
};

std::size_t resisted(ContactFeatures features, bool vf, const Vec3& from, const Vec3& to) {
  Parted parted;
  SerialExecutor executor;
  ContactDetection detection(parted.topology, std::vector<double>(2, 0.0), parted.shape.positions,
                             {"VolCCD+", features, true, {}, 0.01}, executor);
  parted.topology.apply(parted.edit);
  detection.follow(parted.edit, std::vector<double>(parted.topology.mesh().element_slots(), 0.0), parted.x,
                   parted.origins);
  std::vector<FoundContact> found;
  const std::vector<Vec3> x0 = parted.moved(from), x1 = parted.moved(to);
  detection.find(x0, x1, found);
  return static_cast<std::size_t>(std::count_if(found.begin(), found.end(), [&](const FoundContact& c) {
    return c.verdict == ContactVerdict::resist && (c.kind == FeatureKind::vf) == vf;
  }));
}

TEST(TopologyLoop, FacesOfACrackCollideUnlessOnlyTheFirstSurfaceDoes) {
  const Vec3 from(0.1, 0.3, 0.2), to(-0.1, 0.3, 0.2);
  EXPECT_GT(resisted(ContactFeatures::all, true, from, to), 0u);
  EXPECT_GT(resisted(ContactFeatures::boundary, true, from, to), 0u);
  EXPECT_EQ(resisted(ContactFeatures::surface, true, from, to), 0u);
  // Edges around the crack are on the first surface, too.
  EXPECT_GT(resisted(ContactFeatures::surface, false, from, to), 0u);
}

TEST(TopologyLoop, CornersOfACrackCollideOnceTheyHaveComeApart) {
  // The body as it was separated, moved a little along the crack: only copies of one vertex are near each other.
  EXPECT_EQ(resisted(ContactFeatures::all, true, Vec3(0.001, 0, 0), Vec3(0.0005, 0.001, 0)), 0u);
  EXPECT_GT(resisted(ContactFeatures::all, true, Vec3(0.02, 0.2, 0.2), Vec3(-0.02, 0.2, 0.2)), 0u);
}

}  // namespace
}  // namespace volccd::simulation
