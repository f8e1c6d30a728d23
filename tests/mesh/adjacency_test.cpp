#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

bool naive(const Mesh& mesh, Index a, Index b) {
  for (Index v : mesh.vertices(a))
    for (Index w : mesh.vertices(b))
      if (v == w) return true;
  return false;
}

/// Number of pairs and elements for which the table is wrong.
std::size_t wrong(const Mesh& mesh, const Adjacency& table) {
  std::size_t count = 0;
  for (Index a = 0; a < mesh.element_slots(); ++a) {
    if (!mesh.is_live(a)) continue;
    for (Index b = 0; b < mesh.element_slots(); ++b) {
      if (!mesh.is_live(b)) continue;
      count += table.adjacent(a, b) != naive(mesh, a, b);
    }
    const auto vertices = mesh.vertices(a), padded = table.vertices(a);
    count += !std::ranges::equal(padded.first(vertices.size()), vertices) ||
             std::ranges::any_of(padded.subspan(vertices.size()), [&](Index v) { return v != vertices[0]; });
  }
  return count;
}

/// A prism over an n-gon on the given 2 n vertices.
ElementSpec prism(const std::vector<Index>& v, std::int64_t id) {
  ElementSpec element;
  element.type = ElementType::polytope;
  element.vertices = v;
  element.id = id;
  const std::size_t n = v.size() / 2;
  for (std::size_t side = 0; side < 2; ++side) {
    element.faces.push_back(static_cast<Index>(n));
    for (std::size_t i = 0; i < n; ++i) element.faces.push_back(v[side * n + i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    for (Index x : {Index{4}, v[i], v[j], v[n + j], v[n + i]}) element.faces.push_back(x);
  }
  return element;
}

TEST(Adjacency, EqualsComparingAllVertices) {
  for (ElementType type : {ElementType::triangle, ElementType::quad, ElementType::tetrahedron, ElementType::pyramid,
                           ElementType::wedge, ElementType::hexahedron, ElementType::polytope}) {
    const Mesh mesh = permuted(block(type, 4, 3, 3), 11).mesh();
    Adjacency test;
    test.build(mesh);
    EXPECT_EQ(wrong(mesh, test), 0u) << to_string(type);
  }
  const Mesh mesh = permuted(mixed_block(3, 3), 5).mesh();
  Adjacency test;
  test.build(mesh);
  EXPECT_EQ(wrong(mesh, test), 0u);
}

TEST(Adjacency, SeesEveryPairOfPositions) {
  // Two blocks with one common vertex, at every position in both.
  for (const auto& [type, n] : {std::pair{ElementType::tetrahedron, 4u}, std::pair{ElementType::hexahedron, 8u}})
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) {
        Mesh mesh;
        mesh.add_vertices(2 * n);
        ElementSpec a, b;
        a.type = b.type = type;
        for (Index k = 0; k < n; ++k) {
          a.vertices.push_back(k);
          b.vertices.push_back(k == j ? i : n + k);
        }
        b.id = 1;
        mesh.add_element(a);
        mesh.add_element(b);
        Adjacency test;
        test.build(mesh);
        EXPECT_TRUE(test.adjacent(0, 1) && test.adjacent(1, 0)) << i << " " << j;
        mesh.remove_element(1);
        b.vertices[j] = n + j;
        mesh.add_element(b);
        test.build(mesh);
        EXPECT_FALSE(test.adjacent(0, 1) || test.adjacent(1, 0)) << i << " " << j;
      }
}

TEST(Adjacency, FollowsEditsThroughAllSizes) {
  // Tetrahedra, then hexahedra, then polytopes of up to 24 vertices are added, and all of them are removed again.
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Random random(seed);
    Mesh mesh;
    mesh.add_vertices(200);
    Topology topology(std::move(mesh));
    std::vector<Index> all(200);
    for (Index v = 0; v < 200; ++v) all[v] = v;
    std::int64_t id = 0;
    for (std::size_t round = 0; round < 12; ++round) {
      TopologyEdit edit;
      for (Index o = 0; o < topology.mesh().element_slots(); ++o)
        if (topology.mesh().is_live(o) && random.below(3) == 0) edit.removed.push_back(o);
      for (int k = 0; k < 25; ++k) {
        random.shuffle(all);
        const std::size_t kind = random.below(std::min<std::size_t>(round / 2 + 1, 4));
        ElementSpec element;
        element.type = std::array{ElementType::tetrahedron, ElementType::triangle, ElementType::wedge,
                                  ElementType::polytope}[kind];
        const std::size_t n =
            kind == 3 ? 6 + 2 * random.below(10) : static_cast<std::size_t>(vertex_count(element.type));
        element.vertices.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
        if (kind == 3) element = prism(element.vertices, 0);
        element.id = id++;
        edit.added.push_back(element);
      }
      topology.apply(edit);
      ASSERT_EQ(wrong(topology.mesh(), topology.adjacency()), 0u) << "round " << round;
    }
  }
}

}  // namespace
}  // namespace volccd
