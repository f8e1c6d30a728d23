#include <gtest/gtest.h>

#include <limits>

#include <volccd/simulation/topology/node_splitting.hpp>

#include "edit_checks.hpp"

namespace volccd::simulation {
namespace {

std::vector<Body> brittle(double stress = 10, double strain = kNever) {
  Body body;
  body.material.failure_stress = stress;
  body.material.failure_strain = strain;
  return {body, body};
}

/// The stress of a tension along `direction`, at a vertex whose elements have a volume of 2.
VertexStress pull(double value, const Vec3& direction = Vec3::UnitX(), double strain = 0) {
  const Vec3 d = direction.normalized();
  const Eigen::Matrix3d stress = value * d * d.transpose();
  return {2 * stress, 2 * strain, 2};
}

Vec3 centre(const MovingMesh& body, Index o) {
  Vec3 sum = Vec3::Zero();
  for (Index v : body.mesh().vertices(o)) sum += body.x[v];
  return sum / static_cast<double>(body.mesh().vertices(o).size());
}

Index vertex_at(const MovingMesh& body, const Vec3& x) {
  return static_cast<Index>(std::ranges::find(body.x, x) - body.x.begin());
}

TEST(NodeSplitting, PartsTheElementsOfAnyTypeByThePlane) {
  for (const ElementType type : {ElementType::hexahedron, ElementType::tetrahedron, ElementType::triangle}) {
    MovingMesh body(permuted(block(type, 4, 4, type == ElementType::triangle ? 0 : 4), 5));
    const double z = type == ElementType::triangle ? 0 : 2;
    const Index v = vertex_at(body, Vec3(2, 2, z));
    const Vec3 direction(0.9, 0.3, 0.1);
    std::vector<VertexStress> stress(body.x.size(), pull(9.9));
    stress[v] = pull(10.1, direction);
    const auto before = by_id(body);
    std::set<std::int64_t> positive;
    for (Index o : body.topology.features().vertex_elements(v))
      if ((centre(body, o) - body.x[v]).dot(direction) > 0) positive.insert(body.mesh().element_id(o));

    const TopologyProposal proposal = propose_splitting(body.topology, brittle(), body.x, stress);
    ASSERT_EQ(proposal.new_vertices.size(), 1u);
    EXPECT_TRUE(proposal.shapes_of_parents);
    const Index copy = body.mesh().vertex_count();
    body.apply(proposal);
    EXPECT_EQ(body.x[copy], body.x[v]);
    auto after = by_id(body);
    for (auto& [id, list] : after) {
      EXPECT_EQ(std::ranges::count(list, copy), positive.contains(id) ? 1 : 0);
      if (positive.contains(id)) std::ranges::replace(list, copy, v);
    }
    EXPECT_EQ(after, before);
    const ElementHeritage heritage = heritage_of(proposal, body.mesh());
    for (std::size_t i = 0; i < heritage.added.size(); ++i)
      EXPECT_TRUE(positive.contains(body.mesh().element_id(heritage.added[i])));
  }
}

TEST(NodeSplitting, PullThroughoutEndsInSlabs) {
  MovingMesh body(permuted(block(ElementType::hexahedron, 4, 3, 2), 9));
  const std::vector<Body> bodies = brittle();
  int calls = 0;
  for (;; ++calls) {
    ASSERT_LT(calls, 100);
    const std::vector<VertexStress> stress(body.x.size(), pull(11));
    const TopologyProposal proposal = propose_splitting(body.topology, bodies, body.x, stress);
    if (proposal.empty()) break;
    body.apply(proposal);
  }
  EXPECT_GT(calls, 1);
  const auto slabs = components(body);
  ASSERT_EQ(slabs.size(), 4u);
  for (const auto& slab : slabs) EXPECT_EQ(slab.size(), 6u);
}

TEST(NodeSplitting, WorstFirstAndNoNeighbours) {
  MovingMesh body(block(ElementType::hexahedron, 6, 6, 6));
  Random random(4);
  std::vector<VertexStress> stress;
  std::vector<double> excess;
  for (std::size_t v = 0; v < body.x.size(); ++v) {
    excess.push_back(random.uniform(0.5, 2));
    stress.push_back(pull(10 * excess[v]));
  }
  const TopologyProposal proposal = propose_splitting(body.topology, brittle(), body.x, stress);
  std::set<Index> split;
  for (const VertexOrigin& origin : proposal.new_vertices) split.insert(origin.parents[0]);
  ASSERT_GT(split.size(), 3u);
  for (Index v = 0; v < body.mesh().vertex_count(); ++v) {
    std::set<Index> near;
    for (Index o : body.topology.features().vertex_elements(v))
      for (Index w : body.mesh().vertices(o))
        if (split.contains(w)) near.insert(w);
    if (split.contains(v)) {
      EXPECT_GT(excess[v], 1);
      EXPECT_EQ(near.size(), 1u) << "neighbours of one that splits do not";
    } else if (excess[v] > 1 && body.x[v].x() > 0 && body.x[v].x() < 6) {
      EXPECT_TRUE(std::ranges::any_of(near, [&](Index w) { return excess[w] >= excess[v]; }));
    }
  }
}

TEST(NodeSplitting, FailsByPlasticStrainToo) {
  MovingMesh body(block(ElementType::hexahedron, 2, 2, 2));
  std::vector<VertexStress> stress(body.x.size(), pull(1, Vec3::UnitZ(), 0.29));
  EXPECT_TRUE(propose_splitting(body.topology, brittle(kNever, 0.3), body.x, stress).empty());
  stress[13] = pull(1, Vec3::UnitZ(), 0.31);
  const TopologyProposal proposal = propose_splitting(body.topology, brittle(kNever, 0.3), body.x, stress);
  EXPECT_EQ(proposal.edit.added.size(), 4u);
  for (Index o : proposal.edit.removed) EXPECT_GT(centre(body, o).z(), 1);
}

TEST(NodeSplitting, PlasticStrainAloneDoesNotPartWhatIsPressedTogether) {
  MovingMesh body(block(ElementType::hexahedron, 3, 3, 3));
  VertexStress pressed{Eigen::Matrix3d::Zero(), 2 * 0.5, 2};
  for (const double max : {-1.0, 0.0}) {
    pressed.stress.diagonal() = Vec3(-3, max, -2);
    const std::vector<VertexStress> stress(body.x.size(), pressed);
    EXPECT_TRUE(propose_splitting(body.topology, brittle(kNever, 0.3), body.x, stress).empty()) << max;
  }
  pressed.stress.diagonal() = Vec3(-3, 0.1, -2);
  const std::vector<VertexStress> stress(body.x.size(), pressed);
  EXPECT_FALSE(propose_splitting(body.topology, brittle(kNever, 0.3), body.x, stress).empty());
}

TEST(NodeSplitting, LeavesAloneWhatCannotSplit) {
  Shape shape = block(ElementType::hexahedron, 2, 1, 1);
  MovingMesh body(shape);
  std::vector<VertexStress> stress(body.x.size(), pull(50, Vec3::UnitY()));
  EXPECT_TRUE(propose_splitting(body.topology, brittle(), body.x, stress).empty()) << "all on one side";
  stress.assign(body.x.size(), pull(-50));
  EXPECT_TRUE(propose_splitting(body.topology, brittle(), body.x, stress).empty()) << "pressed";
  stress.assign(body.x.size(), pull(50));
  EXPECT_FALSE(propose_splitting(body.topology, brittle(), body.x, stress).empty());
  std::vector<Body> bodies = brittle();
  shape.elements[1].object = 1;
  bodies[1].rigid = true;
  const MovingMesh half_rigid(shape);
  EXPECT_TRUE(propose_splitting(half_rigid.topology, bodies, body.x, stress).empty());
  EXPECT_TRUE(propose_splitting(body.topology, brittle(kNever), body.x, stress).empty());
  stress[4].stress(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(propose_splitting(body.topology, brittle(), body.x, stress), Error);
}

}  // namespace
}  // namespace volccd::simulation
