#include <gtest/gtest.h>

#include <volccd/simulation/topology/node_merging.hpp>
#include <volccd/simulation/topology/node_splitting.hpp>

#include "edit_checks.hpp"

namespace volccd::simulation {
namespace {

std::vector<Body> sticky(double distance = 0.2, double force = 10) {
  Body body;
  body.material.merging_distance = distance;
  body.material.merging_force = force;
  return {body, body};
}

/// A contact of vertex a with the triangle that consists of b and two other vertices.
LoadedContact touch(Index a, Index b, Index c, Index d, double force = 11) {
  LoadedContact loaded{};
  loaded.contact.kind = FeatureKind::vf;
  loaded.contact.vertices = {a, b, c, d};
  loaded.force = force;
  return loaded;
}

TopologyProposal propose(const MovingMesh& body, const std::vector<LoadedContact>& contacts,
                         const std::vector<Body>& bodies = sticky()) {
  return propose_merging(body.topology, bodies, contacts, body.x, body.v, std::vector<double>(body.x.size(), 1.0));
}

Shape tetrahedra(std::vector<Vec3> positions, const std::vector<std::array<Index, 4>>& elements) {
  Shape shape;
  shape.positions = std::move(positions);
  for (const auto& vertices : elements) {
    ElementSpec spec;
    spec.type = ElementType::tetrahedron;
    spec.vertices.assign(vertices.begin(), vertices.end());
    spec.id = static_cast<std::int64_t>(shape.elements.size());
    shape.elements.push_back(spec);
  }
  return shape;
}

/// Two tetrahedra with the common edge 0-1. Vertices 2 and 4 are near each other; `side` says on which sides of them 3
/// and 5 are.
MovingMesh hinge(double side) {
  const Vec3 apex(0.5, side > 0 ? 0.5 : 0.3, side > 0 ? -1.0 : 1.2);
  Shape shape = tetrahedra({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 1, 0), Vec3(0.5, 0.5, 1), Vec3(0.5, 1, -0.1), apex},
                           {{0, 1, 2, 3}});
  ElementSpec other = shape.elements[0];
  other.vertices = side > 0 ? std::vector<Index>{1, 0, 4, 5} : std::vector<Index>{0, 1, 4, 5};
  other.id = 1;
  shape.elements.push_back(other);
  return MovingMesh(shape);
}

TEST(NodeMerging, UndoesASplit) {
  for (const ElementType type : {ElementType::hexahedron, ElementType::tetrahedron}) {
    MovingMesh body(permuted(block(type, 2, 2, 2), 3));
    const auto before = by_id(body);
    const std::vector<Vec3> x = body.x;
    const Index v = static_cast<Index>(std::ranges::find(body.x, Vec3(1, 1, 1)) - body.x.begin()), copy = 27;
    Body brittle;
    brittle.material.failure_stress = 1;
    std::vector<VertexStress> stress(27, VertexStress{Eigen::Matrix3d::Zero(), 0, 1});
    stress[v].stress(0, 0) = 2;
    const TopologyProposal split = propose_splitting(body.topology, std::vector{brittle}, body.x, stress);
    ASSERT_EQ(split.new_vertices.size(), 1u);
    body.apply(split);
    ASSERT_NE(by_id(body), before);
    const TopologyProposal merge = propose(body, {touch(copy, v, v == 0, 2 - (v == 2))});
    EXPECT_TRUE(merge.shapes_of_parents);
    body.apply(merge);
    EXPECT_EQ(by_id(body), before);
    for (std::size_t i = 0; i < 27; ++i) EXPECT_EQ(body.x[i], x[i]);
    EXPECT_TRUE(body.topology.features().vertex_elements(copy).empty());
  }
}

TEST(NodeMerging, KeepsMomentumAndCentreOfMass) {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.append(Shape(shape).translate(Vec3(1.05, 0.02, 0)), 1);
  MovingMesh body(shape);
  Random random(2);
  for (Vec3& v : body.v) v = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  std::vector<double> mass = tet_masses(body);
  mass[8] *= 3;
  const auto total = [&](const std::vector<Vec3>& values) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t v = 0; v < values.size(); ++v) sum += mass[v] * values[v];
    return sum;
  };
  const Vec3 centre = total(body.x), momentum = total(body.v);
  body.apply(propose_merging(body.topology, sticky(), std::vector{touch(1, 8, 10, 12)}, body.x, body.v, mass));
  mass[1] += mass[8], mass[8] = 0;
  EXPECT_NEAR((total(body.x) - centre).norm(), 0, 1e-14);
  EXPECT_NEAR((total(body.v) - momentum).norm(), 0, 1e-14);
  EXPECT_EQ(components(body).size(), 1u);
  EXPECT_EQ(body.mesh().vertices(body.mesh().find_element(6))[0], 1u);
}

TEST(NodeMerging, WeldsBlocksFaceToFaceInSteps) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron}) {
    Shape shape = block(type, 2, 3, 3);
    shape.append(Shape(shape).translate(Vec3(2.05, 0.02, 0.01)), 1);
    MovingMesh body(shape);
    std::vector<LoadedContact> contacts;
    const auto n = static_cast<Index>(body.x.size() / 2);
    for (Index v = 0; v < n; ++v)
      if (shape.positions[v].x() == 2) contacts.push_back(touch(v, n + v - 2, n + 1, n + 4));
    int calls = 0;
    for (TopologyProposal proposal; !(proposal = propose(body, contacts)).empty(); ++calls) {
      EXPECT_LE(proposal.moved.size(), 9u);
      body.apply(proposal);
      ASSERT_LT(calls, 50);
    }
    EXPECT_GT(calls, 1) << "elements change once a call";
    std::set<Index> used;
    for (Index o : body.elements()) used.insert(body.mesh().vertices(o).begin(), body.mesh().vertices(o).end());
    EXPECT_EQ(used.size(), 2 * n - 16);
    EXPECT_EQ(components(body).size(), 1u);
    if (type != ElementType::tetrahedron) continue;
    EXPECT_LE(boundary_of(body).max_elements, 2);
    EXPECT_GT(min_volume(body), 0);
    EXPECT_LT(boundary_of(body).outer_area, 2 * (2 * 9 + 4 * 6) - 17);  // both faces of 9 are interior now
  }
}

TEST(NodeMerging, NeedsForceAndNearnessOfBothParts) {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.append(Shape(shape).translate(Vec3(1.1, 0, 0)), 1);
  const MovingMesh body(shape);
  EXPECT_FALSE(propose(body, {touch(1, 8, 10, 12)}).empty());
  EXPECT_TRUE(propose(body, {touch(1, 8, 10, 12, 9)}).empty());
  EXPECT_TRUE(propose(body, {touch(1, 8, 10, 12)}, sticky(0.09)).empty());
  EXPECT_TRUE(propose(body, {touch(1, 9, 10, 12)}).empty()) << "vertex 9 is far";
  std::vector<Body> bodies = sticky();
  for (std::size_t i : {0, 1}) {
    bodies = sticky();
    bodies[i].material.merging_force = 12;
    EXPECT_TRUE(propose(body, {touch(1, 8, 10, 12)}, bodies).empty());
  }
  bodies = sticky();
  bodies[1].material.merging_distance = 0.05;
  EXPECT_TRUE(propose(body, {touch(1, 8, 10, 12)}, bodies).empty());
  bodies = sticky();
  bodies[0].rigid = true;
  EXPECT_TRUE(propose(body, {touch(1, 8, 10, 12)}, bodies).empty());
}

TEST(NodeMerging, NearestPairOfAnEdgeContactFirst) {
  Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  shape.append(Shape(shape).translate(Vec3(1.1, 0, 0)), 1);
  MovingMesh body(shape);
  LoadedContact edges = touch(1, 3, 8, 10);
  edges.contact.kind = FeatureKind::ee;
  body.x[10].x() = 1.04;  // beside vertex 3
  const TopologyProposal proposal = propose(body, {edges});
  ASSERT_EQ(proposal.moved.size(), 1u);
  EXPECT_EQ(proposal.moved[0].vertex, 3u);
  EXPECT_NEAR(proposal.moved[0].position.x(), 1.02, 1e-15);
}

TEST(NodeMerging, RefusesWhatWouldDegenerate) {
  const std::vector<Body> bodies = sticky(10);
  const MovingMesh one(tetrahedra({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, {{0, 1, 2, 3}}));
  EXPECT_TRUE(propose(one, {touch(0, 1, 2, 3)}, bodies).empty()) << "one element has both";

  EXPECT_FALSE(propose(hinge(1), {touch(4, 2, 0, 1)}).empty()) << "closes the hinge";
  EXPECT_TRUE(propose(hinge(-1), {touch(4, 2, 0, 1)}).empty()) << "both on one side of the face";

  // Vertex 4 is far behind the face 1 2 3 of the other tetrahedron, so that moving to the middle of 0 and 4 inverts it.
  const MovingMesh behind(tetrahedra({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(2, 2, 2),
                                      Vec3(3, 2, 2), Vec3(2, 3, 2), Vec3(2, 2, 3)},
                                     {{0, 1, 2, 3}, {4, 5, 6, 7}}));
  EXPECT_TRUE(propose(behind, {touch(0, 4, 5, 6)}, bodies).empty());
  EXPECT_FALSE(propose(behind, {touch(3, 4, 5, 6)}, bodies).empty());
}

TEST(NodeMerging, RefusesAThirdElementAtAFaceAndDoubledShells) {
  // Two tetrahedra have the face 0 1 2, and a third one has 0, 1 and vertex 5, which is near 2. The two are on
  // different sides of the face or, in the invalid case, both on the side where the third one is not.
  for (const double z : {-1.0, 1.2}) {
    const MovingMesh fan(tetrahedra({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 1, 0), Vec3(0.5, 0.3, 1),
                                     Vec3(0.5, 0.3, z), Vec3(0.5, 1.1, 0), Vec3(0.5, 1, -1.5)},
                                    {{0, 1, 2, 3}, {1, 0, 2, 4}, {1, 0, 5, 6}}));
    EXPECT_TRUE(propose(fan, {touch(5, 2, 3, 4)}).empty());
  }

  Shape sheet = block(ElementType::triangle, 1, 1, 0);  // 0 1 3 and 0 3 2
  sheet.positions[1] = Vec3(0.1, 0.95, 0);
  sheet.positions[2] = Vec3(0, 1, 0.1);
  const MovingMesh shells(sheet);
  EXPECT_TRUE(propose(shells, {touch(1, 2, 0, 3)}).empty());
}

}  // namespace
}  // namespace volccd::simulation
