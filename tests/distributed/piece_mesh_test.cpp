#include <volccd/distributed/piece_mesh.hpp>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/colliding_scenes.hpp>

namespace volccd::distributed {
namespace {

/// Each `step`-th of the first `count` elements of a mesh.
Elements every(Index step, Index count, const Mesh& mesh) {
  Elements elements;
  for (Index o = 0; o < count; o += step) elements.add(mesh, o);
  return elements;
}

/// An owner for each vertex of the elements: a function of the id.
std::vector<int> owners_of(const Elements& elements) {
  std::vector<int> owners;
  for (const std::int64_t id : elements.vertices) owners.push_back(static_cast<int>(id % 5));
  return owners;
}

bool update(PieceMesh& piece, const Elements& elements, std::int64_t group = 1) {
  const PieceMesh::Config config{.vertex_group = group};
  if (piece.serves(elements, config)) return false;
  piece.build({.elements = elements, .owners = owners_of(elements)}, {}, config, serial_executor());
  return true;
}

/// That the piece has the elements, with the ids of their vertices, in any case.
void expect_elements(const PieceMesh& piece, const Elements& elements) {
  const Mesh& mesh = piece.topology().mesh();
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Index slot = mesh.find_element(elements.ids[i]);
    ASSERT_NE(slot, kNone);
    Elements found;
    found.add(mesh, slot);
    Elements expected;
    expected.add(elements, i);
    EXPECT_EQ(found.types, expected.types);
    EXPECT_EQ(found.objects, expected.objects);
    EXPECT_EQ(found.vertices, expected.vertices);
    EXPECT_EQ(found.faces, expected.faces);
  }
}

TEST(PieceMesh, HasItsElementsAndTheirVertices) {
  for (const cases::Scene& scene : cases::small_scenes(3, 0.1)) {
    const Elements elements = every(3, scene.topology.mesh().element_slots(), scene.topology.mesh());
    PieceMesh piece;
    EXPECT_TRUE(piece.empty());
    EXPECT_TRUE(update(piece, elements));
    EXPECT_EQ(piece.topology().mesh().element_count(), elements.size());
    EXPECT_EQ(piece.topology().features().vertex_count(), piece.topology().mesh().vertex_count());
    expect_elements(piece, elements);
    ASSERT_EQ(piece.owners().size(), piece.vertex_ids().size());
    for (std::size_t v = 0; v < piece.owners().size(); ++v) EXPECT_EQ(piece.owners()[v], piece.vertex_ids()[v] % 5);
  }
}

/// A piece that asks for more vertices than it has to learns which of them are complete, and keeps the elements at the
/// others.
TEST(PieceMesh, KeepsTheElementsAroundItsCut) {
  for (const cases::Scene& scene : cases::small_scenes(3, 0.1)) {
    const Topology& whole = scene.topology;
    const Mesh& mesh = whole.mesh();
    const Elements elements = every(1, mesh.element_slots() / 2, mesh), all = every(1, mesh.element_slots(), mesh);
    PieceMesh piece;
    piece.build({.elements = elements, .owners = owners_of(elements)}, {.elements = all, .owners = owners_of(all)}, {},
                serial_executor());
    const Piece part = piece.piece();
    ASSERT_NE(part.cut_stars, nullptr) << scene.name;
    const auto count = [](const Topology& topology, Index v) { return topology.features().vertex_elements(v).size(); };
    std::size_t cut = 0;
    for (Index v = 0; v < piece.vertex_ids().size(); ++v) {
      const auto at = std::ranges::lower_bound(mesh.vertex_ids(), piece.vertex_ids()[v]) - mesh.vertex_ids().begin();
      const std::size_t held = count(piece.topology(), v), of_mesh = count(whole, static_cast<Index>(at));
      EXPECT_EQ(part.is_complete(v), held == of_mesh) << scene.name;
      if (part.is_complete(v) || held == 0) continue;
      EXPECT_EQ(count(*part.cut_stars, v), of_mesh) << scene.name;
      ++cut;
    }
    EXPECT_GT(cut, 0u) << scene.name;
    for (Index o = 0; o < part.cut_stars->mesh().element_slots(); ++o)
      EXPECT_TRUE(std::ranges::any_of(part.cut_stars->mesh().vertices(o), [&](Index v) {
        return !part.is_complete(v) && count(piece.topology(), v) > 0;
      })) << scene.name;
  }
}

TEST(PieceMesh, HoldsWholeGroupsOfVertices) {
  const cases::Scene scene = cases::colliding("cells", block(ElementType::hexahedron, 2, 2, 1), 1, 0);
  const Elements elements = every(3, 8, scene.topology.mesh());
  PieceMesh piece;
  update(piece, elements, 3);
  expect_elements(piece, elements);
  ASSERT_EQ(piece.vertex_ids().size() % 3, 0u);
  for (std::size_t v = 0; v < piece.vertex_ids().size(); ++v) {
    EXPECT_EQ(piece.vertex_ids()[v], piece.vertex_ids()[v / 3 * 3] + static_cast<std::int64_t>(v % 3));
    EXPECT_EQ(piece.vertex_ids()[v / 3 * 3] % 3, 0);
    const bool used = std::ranges::count(elements.vertices, piece.vertex_ids()[v]) > 0;
    EXPECT_EQ(piece.owners()[v], used ? piece.vertex_ids()[v] % 5 : PieceMesh::kNoRank);
  }
}

TEST(PieceMesh, GroupsOfNegativeIds) {
  Elements elements;
  elements.add(ElementType::triangle, std::vector<std::int64_t>{-4, -1, 1}, 0, 0);
  PieceMesh piece;
  update(piece, elements, 3);
  const auto ids = piece.vertex_ids();
  EXPECT_EQ(std::vector(ids.begin(), ids.end()), (std::vector<std::int64_t>{-6, -5, -4, -3, -2, -1, 0, 1, 2}));
}

TEST(PieceMesh, IsKeptForFewerElementsAndMadeAnewForOthers) {
  const cases::Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 3, 2), 1, 0);
  const Mesh& mesh = scene.topology.mesh();
  PieceMesh piece;
  const auto updated = [&](Index count) {
    const Elements elements = every(1, count, mesh);
    const bool result = update(piece, elements);
    if (count > 0) expect_elements(piece, elements);
    return result;
  };
  EXPECT_TRUE(updated(100));
  EXPECT_FALSE(updated(100));
  EXPECT_FALSE(updated(90));
  EXPECT_TRUE(updated(70));
  EXPECT_TRUE(updated(100));
  EXPECT_TRUE(update(piece, every(1, 100, mesh), 3));
  piece.clear();
  EXPECT_TRUE(updated(100));
  EXPECT_TRUE(updated(0));
  EXPECT_TRUE(piece.empty());
  EXPECT_FALSE(updated(0));
}

}  // namespace
}  // namespace volccd::distributed
