#include <volccd/distributed/piece_mesh.hpp>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/colliding_scenes.hpp>

namespace volccd::distributed {
namespace {

std::vector<Index> every(Index step, Index count) {
  std::vector<Index> slots;
  for (Index o = 0; o < count; o += step) slots.push_back(o);
  return slots;
}

/// That the piece has the elements, with the ids of their vertices, in any case.
void expect_elements(const PieceMesh& piece, const Mesh& whole, std::span<const Index> elements) {
  const Mesh& mesh = piece.topology().mesh();
  for (const Index o : elements) {
    const Index slot = mesh.find_element(whole.element_id(o));
    ASSERT_NE(slot, kNone);
    EXPECT_EQ(piece.whole_element(slot), o);
    EXPECT_EQ(mesh.type(slot), whole.type(o));
    EXPECT_EQ(mesh.object(slot), whole.object(o));
    const auto vertices = mesh.vertices(slot), expected = whole.vertices(o);
    ASSERT_EQ(vertices.size(), expected.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      EXPECT_EQ(piece.whole_vertex(vertices[i]), expected[i]);
      EXPECT_EQ(mesh.vertex_id(vertices[i]), whole.vertex_id(expected[i]));
    }
    EXPECT_EQ(mesh.polytope_faces(slot).size(), whole.polytope_faces(o).size());
  }
}

TEST(PieceMesh, HasItsElementsAndTheirVertices) {
  for (const cases::Scene& scene : cases::small_scenes(3, 0.1)) {
    const Mesh& whole = scene.topology.mesh();
    const std::vector<Index> elements = every(3, whole.element_slots());
    PieceMesh piece;
    piece.update(scene.topology, elements, 1, serial_executor());
    EXPECT_EQ(piece.topology().mesh().element_count(), elements.size());
    EXPECT_EQ(piece.topology().features().vertex_count(), piece.topology().mesh().vertex_count());
    expect_elements(piece, whole, elements);
    const Motion& motion = piece.motion_of(scene.motion);
    for (Index v = 0; v < motion.vertex_count(); ++v)
      for (int c = 0; c < 2; ++c) EXPECT_EQ(motion.point(v, c), scene.motion.point(piece.whole_vertex(v), c));
  }
}

TEST(PieceMesh, HoldsWholeGroupsOfVertices) {
  const cases::Scene scene = cases::colliding("cells", block(ElementType::hexahedron, 2, 2, 1), 1, 0);
  PieceMesh piece;
  piece.update(scene.topology, every(3, 8), 3, serial_executor());
  expect_elements(piece, scene.topology.mesh(), every(3, 8));
  const Mesh& mesh = piece.topology().mesh();
  ASSERT_EQ(mesh.vertex_count() % 3, 0u);
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_EQ(piece.whole_vertex(v), piece.whole_vertex(v / 3 * 3) + v % 3);
}

TEST(PieceMesh, IsKeptForFewerElementsAndMadeAnewForOthers) {
  cases::Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 3, 2), 1, 0);
  auto version_for = [&, piece = PieceMesh()](std::vector<Index> elements) mutable {
    piece.update(scene.topology, elements, 1, serial_executor());
    expect_elements(piece, scene.topology.mesh(), elements);
    return piece.topology().version();
  };
  std::vector<Index> elements = every(1, 100);
  const std::uint64_t first = version_for(elements);
  EXPECT_EQ(version_for(elements), first);
  EXPECT_EQ(version_for(every(1, 90)), first);
  EXPECT_NE(version_for(every(1, 70)), first);
  EXPECT_NE(version_for(elements), first);
  const std::uint64_t last = version_for(elements);
  scene.topology.apply({.removed = {1}});
  elements.erase(elements.begin() + 1);
  EXPECT_NE(version_for(elements), last);
}

}  // namespace
}  // namespace volccd::distributed
