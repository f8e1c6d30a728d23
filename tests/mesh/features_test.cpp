#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "mesh/naive_features.hpp"

namespace volccd {
namespace {

constexpr EdgeSet kEdgeSets[] = {EdgeSet::triangulated, EdgeSet::polytope};
constexpr ElementType kTypes[] = {ElementType::triangle, ElementType::quad,  ElementType::tetrahedron,
                                  ElementType::pyramid,  ElementType::wedge, ElementType::hexahedron,
                                  ElementType::polytope};

Features built(const Mesh& mesh, EdgeSet edge_set) {
  Features features(edge_set);
  features.build(mesh);
  return features;
}

Mesh single(ElementType type, std::vector<Index> vertices, std::vector<Index> faces = {}) {
  Mesh mesh;
  mesh.add_vertices(*std::max_element(vertices.begin(), vertices.end()) + 1);
  ElementSpec element;
  element.type = type;
  element.vertices = std::move(vertices);
  element.faces = std::move(faces);
  mesh.add_element(element);
  return mesh;
}

TEST(Features, SingleElementsHaveTheKnownCounts) {
  struct Known {
    ElementType type;
    std::vector<Index> vertices;
    Index edges, diagonals, triangles;
  };
  const Known known[] = {{ElementType::triangle, {2, 0, 1}, 3, 0, 1},
                         {ElementType::quad, {2, 0, 1, 3}, 4, 1, 2},
                         {ElementType::tetrahedron, {2, 0, 1, 3}, 6, 0, 4},
                         {ElementType::pyramid, {4, 2, 0, 1, 3}, 8, 1, 6},
                         {ElementType::wedge, {4, 2, 0, 1, 3, 5}, 9, 3, 8},
                         {ElementType::hexahedron, {4, 2, 0, 1, 3, 5, 7, 6}, 12, 6, 12}};
  for (const Known& k : known) {
    const Mesh mesh = single(k.type, k.vertices);
    EXPECT_EQ(built(mesh, EdgeSet::polytope).edge_count(), k.edges) << to_string(k.type);
    EXPECT_EQ(built(mesh, EdgeSet::triangulated).edge_count(), k.edges + k.diagonals) << to_string(k.type);
    EXPECT_EQ(built(mesh, EdgeSet::triangulated).triangle_count(), k.triangles) << to_string(k.type);
    EXPECT_EQ(built(mesh, EdgeSet::polytope).element_triangles(0).size(), k.triangles) << to_string(k.type);
  }
}

TEST(Features, TriangulatedVolumeBoundariesAreSpheres) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Mesh mesh = permuted(mixed_block(1, 1), seed).mesh();
    const Features features = built(mesh, EdgeSet::triangulated);
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      const auto v = mesh.vertices(o).size(), e = features.element_edges(o).size(),
                 f = features.element_triangles(o).size();
      EXPECT_EQ(v + f, e + (is_shell(mesh.type(o)) ? 1 : 2)) << to_string(mesh.type(o));
    }
  }
}

TEST(Features, EqualEnumerationOnEveryTypeAndMix) {
  for (EdgeSet edge_set : kEdgeSets)
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      for (ElementType type : kTypes) {
        const Mesh mesh = permuted(block(type, 3, 2, 2), seed).mesh();
        EXPECT_EQ(test::inconsistency(mesh, built(mesh, edge_set)), "") << to_string(type);
      }
      const Mesh mesh = permuted(mixed_block(2, 2), seed).mesh();
      EXPECT_EQ(test::inconsistency(mesh, built(mesh, edge_set)), "");
    }
}

TEST(Features, WithoutEdgesAndTrianglesHaveVerticesAlone) {
  const Mesh mesh = permuted(mixed_block(2, 2), 1).mesh();
  const Features all = built(mesh, EdgeSet::triangulated), none = built(mesh, EdgeSet::none);
  EXPECT_EQ(none.edge_slots() + none.triangle_slots(), 0u);
  EXPECT_EQ(none.vertex_count(), all.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_TRUE(std::ranges::equal(none.vertex_elements(v), all.vertex_elements(v)));
  for (Index o = 0; o < mesh.element_slots(); ++o)
    EXPECT_TRUE(none.element_edges(o).empty() && none.element_triangles(o).empty());
  EXPECT_LT(none.bytes(), all.bytes() / 2);
}

TEST(Features, NeighboursOfDifferentTypeShareTheirTriangles) {
  // In a conforming block, every interior triangle belongs to two volumes of any type, including where they split a
  // quad. A column of tetrahedra has other diagonals, so that only the four other types are used.
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Shape shape = block(ElementType::hexahedron, 2, 2, 2);
    ElementSpec& cell = shape.elements[3];  // one of the eight elements as a polytope
    for (const auto& f :
         {std::array{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}) {
      cell.faces.push_back(4);
      for (int i : f) cell.faces.push_back(cell.vertices[static_cast<std::size_t>(i)]);
    }
    cell.type = ElementType::polytope;
    const Mesh mesh = permuted(shape, seed).mesh();
    const Features features = built(mesh, EdgeSet::triangulated);
    Index outer = 0;
    for (Index f = 0; f < features.triangle_slots(); ++f) outer += features.triangle_elements(f).size() == 1;
    EXPECT_EQ(outer, 6u * 4u * 2u);
    EXPECT_EQ(features.triangle_count(), (8u * 12u + outer) / 2u);
  }
}

TEST(Features, VisitsEdgesOfADegeneratePolytopeOnce) {
  // Two quads on the same vertices with opposite orientations: their diagonals coincide, and so do their triangles.
  const Mesh pillow = single(ElementType::polytope, {0, 1, 2, 3}, {4, 0, 1, 2, 3, 4, 3, 2, 1, 0});
  // A quad and two triangles that share its diagonal as an edge.
  const Mesh folded = single(ElementType::polytope, {0, 1, 2, 3}, {4, 0, 1, 2, 3, 3, 0, 1, 2, 3, 0, 2, 3});
  for (const Mesh* mesh : {&pillow, &folded}) {
    std::multiset<test::Edge> edges;
    std::multiset<test::Triangle> triangles;
    visit_boundary(
        *mesh, 0, EdgeSet::triangulated,
        [&](Index a, Index b) {
          edges.insert({std::min(a, b), std::max(a, b)});
        },
        [&](Index a, Index b, Index c) {
          test::Triangle t{a, b, c};
          std::sort(t.begin(), t.end());
          triangles.insert(t);
        });
    EXPECT_EQ(edges, (std::multiset<test::Edge>{{0, 1}, {1, 2}, {2, 3}, {0, 3}, {0, 2}}));
    EXPECT_EQ(triangles, (std::multiset<test::Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(test::inconsistency(*mesh, built(*mesh, EdgeSet::triangulated)), "");
    EXPECT_EQ(test::inconsistency(*mesh, built(*mesh, EdgeSet::polytope)), "");
  }
}

TEST(Features, FansPolytopeFacesFromTheSmallestSlot) {
  // A hexagonal prism whose vertices are numbered against the order of the faces.
  std::vector<Index> vertices, faces = {6, 7, 3, 9, 5, 11, 1, 6, 0, 10, 4, 8, 2, 6};
  for (Index i = 0; i < 12; ++i) vertices.push_back(i);
  const std::vector<Index> bottom(faces.begin() + 1, faces.begin() + 7), top(faces.begin() + 8, faces.begin() + 14);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t j = (i + 1) % 6;
    for (Index x : {Index{4}, bottom[i], bottom[j], top[j], top[i]}) faces.push_back(x);
  }
  const Mesh mesh = single(ElementType::polytope, vertices, faces);
  const Features features = built(mesh, EdgeSet::triangulated);
  EXPECT_EQ(test::inconsistency(mesh, features), "");
  EXPECT_EQ(features.edge_count(), 18u + 3u + 3u + 6u);
  EXPECT_EQ(features.triangle_count(), 4u + 4u + 12u);
  for (Index v : {3, 9, 5}) EXPECT_NE(features.find_edge(1, v), kNone) << "fan around 1 misses " << v;
  EXPECT_EQ(features.find_edge(7, 9), kNone);
  EXPECT_EQ(built(mesh, EdgeSet::polytope).edge_count(), 18u);
}

TEST(Features, FindsNothingThatIsNotThere) {
  const Mesh mesh = block(ElementType::tetrahedron, 2, 2, 2).mesh();
  const Features features = built(mesh, EdgeSet::triangulated);
  const auto naive = test::naive_features(mesh, EdgeSet::triangulated);
  for (Index a = 0; a < mesh.vertex_count(); ++a)
    for (Index b = a + 1; b < mesh.vertex_count(); ++b) {
      EXPECT_EQ(features.find_edge(a, b) != kNone, naive.edges.count({a, b}) == 1);
      for (Index c = b + 1; c < mesh.vertex_count(); ++c)
        EXPECT_EQ(features.find_triangle(a, b, c) != kNone, naive.triangles.count({a, b, c}) == 1);
    }
  EXPECT_EQ(Features().find_edge(0, 1), kNone);
}

TEST(Features, OfAnEmptyMeshAreNone) {
  Features features;
  features.build(Mesh());
  EXPECT_EQ(features.vertex_slots() + features.edge_slots() + features.triangle_slots(), 0u);
  Mesh unused;
  unused.add_vertices(3);
  features.build(unused);
  EXPECT_EQ(features.vertex_slots(), 3u);
  EXPECT_EQ(features.vertex_count(), 0u);
  EXPECT_TRUE(features.vertex_elements(2).empty());
}

TEST(Features, MemoryStaysBoundedOverManyChanges) {
  Topology topology(block(ElementType::tetrahedron, 8, 8, 8).mesh());
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const std::size_t bytes = features.bytes();
  Random random(3);
  for (int round = 0; round < 60; ++round) {
    TopologyEdit edit;
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (random.below(3) == 0) {
        edit.removed.push_back(o);
        ElementSpec element;
        element.type = mesh.type(o);
        element.vertices.assign(mesh.vertices(o).begin(), mesh.vertices(o).end());
        element.id = mesh.element_id(o);
        edit.added.push_back(element);
      }
    topology.apply(edit);
  }
  EXPECT_EQ(test::inconsistency(mesh, features), "");
  EXPECT_LT(features.bytes(), 3 * bytes);
  // Almost all elements are removed; the unused memory of the lists is freed.
  const std::size_t before = features.bytes();
  TopologyEdit last;
  for (Index o = 10; o < mesh.element_slots(); ++o) last.removed.push_back(o);
  topology.apply(last);
  EXPECT_EQ(test::inconsistency(mesh, features), "");
  EXPECT_LT(features.bytes(), before);
}

}  // namespace
}  // namespace volccd
