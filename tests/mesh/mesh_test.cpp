#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>
#include <utility>

#include <volccd/core/error.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

ElementSpec spec(ElementType type, std::vector<Index> vertices, std::int64_t id = 0, std::vector<Index> faces = {}) {
  ElementSpec element;
  element.type = type;
  element.vertices = std::move(vertices);
  element.faces = std::move(faces);
  element.id = id;
  return element;
}

Mesh with_vertices(Index n) {
  Mesh mesh;
  mesh.add_vertices(n);
  return mesh;
}

const std::vector<Index> kTetraFaces = {3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3};

TEST(Mesh, HoldsWhatItWasGiven) {
  const Shape shape = permuted(mixed_block(2, 2), 7);
  const Mesh mesh = shape.mesh();
  ASSERT_EQ(mesh.element_count(), shape.elements.size());
  for (const ElementSpec& element : shape.elements) {
    const Index o = mesh.find_element(element.id);
    ASSERT_NE(o, kNone);
    EXPECT_EQ(mesh.element_id(o), element.id);
    EXPECT_EQ(mesh.type(o), element.type);
    EXPECT_EQ(mesh.object(o), element.object);
    EXPECT_TRUE(std::ranges::equal(mesh.vertices(o), element.vertices));
    EXPECT_TRUE(std::ranges::equal(mesh.polytope_faces(o), element.faces));
  }
  EXPECT_EQ(mesh.find_element(-1), kNone);
}

TEST(Mesh, TakesEmptySlotsAgain) {
  Mesh mesh = block(ElementType::tetrahedron, 3, 3, 3).mesh();
  const Index slots = mesh.element_slots();
  const std::size_t bytes = mesh.bytes();
  for (int round = 0; round < 50; ++round) {
    std::vector<ElementSpec> removed;
    for (Index o = static_cast<Index>(round % 3); o < slots; o += 3) {
      const auto v = mesh.vertices(o);
      removed.push_back(spec(mesh.type(o), {v.begin(), v.end()}, mesh.element_id(o)));
      mesh.remove_element(o);
      EXPECT_FALSE(mesh.is_live(o));
      EXPECT_TRUE(mesh.vertices(o).empty() && mesh.polytope_faces(o).empty());
      EXPECT_EQ(mesh.find_element(removed.back().id), kNone);
    }
    EXPECT_EQ(mesh.element_count(), slots - removed.size());
    for (const ElementSpec& element : removed) {
      const Index o = mesh.add_element(element);
      EXPECT_EQ(mesh.find_element(element.id), o);
      EXPECT_TRUE(std::ranges::equal(mesh.vertices(o), element.vertices));
    }
  }
  EXPECT_EQ(mesh.element_slots(), slots);
  EXPECT_LT(mesh.bytes(), 2 * bytes);
}

TEST(Mesh, KnowsWhetherIdsAscend) {
  const auto triangle = [](std::int64_t id) { return spec(ElementType::triangle, {0, 1, 2}, id); };
  const auto with = [&](std::initializer_list<std::int64_t> ids) {
    Mesh mesh = with_vertices(3);
    for (const std::int64_t id : ids) mesh.add_element(triangle(id));
    return mesh;
  };
  EXPECT_TRUE(with({}).element_ids_ascend());
  EXPECT_TRUE(with({2, 5, 9}).element_ids_ascend());
  EXPECT_FALSE(with({2, 9, 5}).element_ids_ascend());
  // In an empty slot: between its neighbours, before the one and after the other.
  for (const auto& [id, ascend] : {std::pair{6, true}, std::pair{1, false}, std::pair{10, false}}) {
    Mesh mesh = with({2, 5, 9});
    mesh.remove_element(1);
    EXPECT_TRUE(mesh.element_ids_ascend());
    mesh.add_element(triangle(id));
    EXPECT_EQ(mesh.element_ids_ascend(), ascend) << id;
  }
}

TEST(Mesh, RefusesBadVertexIds) {
  Mesh mesh;
  const std::vector<std::int64_t> good = {-5, 3, 9}, repeated = {10, 10}, low = {9, 10};
  mesh.add_vertices(good);
  EXPECT_THROW(mesh.add_vertices(repeated), InputError);
  EXPECT_THROW(mesh.add_vertices(low), InputError);
  EXPECT_EQ(mesh.vertex_count(), 3u);
  mesh.add_vertices(2);
  EXPECT_EQ(mesh.vertex_id(4), 11);
  const std::vector<std::int64_t> last = {std::numeric_limits<std::int64_t>::max() - 1};
  mesh.add_vertices(last);
  EXPECT_THROW(mesh.add_vertices(2), InputError);
  mesh.add_vertices(1);
  EXPECT_THROW(mesh.add_vertices(kNone - 5), InputError);
}

TEST(Mesh, RefusesBadElements) {
  const std::vector<ElementSpec> bad = {
      spec(ElementType::none, {}),
      spec(static_cast<ElementType>(11), {0, 1, 2, 3, 4, 5, 6, 7}),
      spec(ElementType::tetrahedron, {0, 1, 2}),
      spec(ElementType::tetrahedron, {0, 1, 2, 3, 4}),
      spec(ElementType::tetrahedron, {0, 1, 2, 9}),
      spec(ElementType::tetrahedron, {0, 1, 2, kNone}),
      spec(ElementType::tetrahedron, {0, 1, 2, 0}),
      spec(ElementType::tetrahedron, {0, 1, 2, 3}, 0, kTetraFaces),
      spec(ElementType::polytope, {0, 1, 2}, 0, {3, 0, 1, 2, 3, 0, 1, 2}),                 // too few vertices
      spec(ElementType::polytope, {0, 1, 2, 3}),                                           // no faces
      spec(ElementType::polytope, {0, 1, 2, 3, 4}, 0, kTetraFaces),                        // a vertex that no face uses
      spec(ElementType::polytope, {0, 1, 2, 4}, 0, kTetraFaces),                           // a face uses another vertex
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3}),  // open
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 3, 0, 1, 2}),  // three at an edge
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {2, 0, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3}),
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {4, 0, 1, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3}),
      // the stream ends early
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0}),
      spec(ElementType::polytope, {0, 1, 2, 3}, 0, {kNone, 0, 1, 2}),
  };
  Mesh mesh = with_vertices(9);
  for (const ElementSpec& element : bad) {
    EXPECT_THROW(mesh.add_element(element), InputError) << "case " << &element - bad.data();
    EXPECT_EQ(mesh.element_slots(), 0u);
  }
  mesh.add_element(spec(ElementType::polytope, {0, 1, 2, 3}, 17, kTetraFaces));
  try {
    mesh.add_element(spec(ElementType::triangle, {0, 1, 2}, 17));
    FAIL() << "an id that is taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), "mesh");
    EXPECT_EQ(error.dataset(), "elements");
    EXPECT_EQ(error.index(), 17);
  }
  EXPECT_EQ(mesh.element_count(), 1u);
}

TEST(Mesh, RefusesRepeatedVertexInLargePolytope) {
  std::vector<Index> vertices, faces;
  for (Index side = 0; side < 2; ++side) {
    faces.push_back(20);
    for (Index i = 0; i < 20; ++i) faces.push_back(20 * side + i);
  }
  for (Index i = 0; i < 20; ++i) {
    const Index j = (i + 1) % 20;
    for (Index x : {Index{4}, i, j, 20 + j, 20 + i}) faces.push_back(x);
  }
  for (Index i = 0; i < 40; ++i) vertices.push_back(i);
  Mesh mesh = with_vertices(40);
  mesh.add_element(spec(ElementType::polytope, vertices, 1, faces));
  vertices.push_back(3);
  EXPECT_THROW(mesh.add_element(spec(ElementType::polytope, vertices, 2, faces)), InputError);
}

}  // namespace
}  // namespace volccd
