// Complexes of simplices after any sequence of edits: they have the features of the mesh, and map them to it.
#include <volccd/culling/flood/detail/simplex_complex.hpp>

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/executor.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/topology_editor.hpp"

namespace volccd::detail {
namespace {

/// Each feature of the mesh is a simplex.
void expect_features_of_mesh(const Features& features, const Features& simplices) {
  for (Index e = 0; e < features.edge_slots(); ++e) {
    if (features.edge_elements(e).empty()) continue;
    const Index found = simplices.find_edge(features.edge(e)[0], features.edge(e)[1]);
    EXPECT_TRUE(found != kNone && !simplices.edge_elements(found).empty());
  }
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    if (features.triangle_elements(f).empty()) continue;
    const auto& t = features.triangle(f);
    const Index found = simplices.find_triangle(t[0], t[1], t[2]);
    EXPECT_TRUE(found != kNone && !simplices.triangle_elements(found).empty());
  }
}

/// Each edge and each triangle is mapped to that of the mesh with the same vertices, if there is one.
void expect_mapped(const SimplexComplex& complex, const Features& features) {
  const Features& simplices = complex.topology().features();
  TestBatch tests, expected;
  std::vector<Index> edges;
  for (Index e = 0; e < simplices.edge_slots(); ++e)
    if (!simplices.edge_elements(e).empty()) edges.push_back(e);
  const auto in_mesh = [&](Index e) { return features.find_edge(simplices.edge(e)[0], simplices.edge(e)[1]); };
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (const std::size_t k : {i + 1, i + 7}) {
      const Index e = edges[i], g = edges[k % edges.size()];
      tests.ee.push_back({std::min(e, g), std::max(e, g)});
      const Index a = in_mesh(e), b = in_mesh(g);
      if (a != kNone && b != kNone) expected.ee.push_back({std::min(a, b), std::max(a, b)});
    }
  for (Index f = 0; f < simplices.triangle_slots(); ++f) {
    if (simplices.triangle_elements(f).empty()) continue;
    tests.vf.push_back({0, f});
    const auto& t = simplices.triangle(f);
    const Index found = features.find_triangle(t[0], t[1], t[2]);
    if (found != kNone) expected.vf.push_back({0, found});
  }
  complex.to_mesh_features(tests, 0, 0);
  EXPECT_EQ(tests.vf, expected.vf);
  EXPECT_EQ(tests.ee, expected.ee);
}

void expect_follows(Mesh mesh, std::vector<ElementType> types, std::uint64_t seed) {
  Topology topology(std::move(mesh));
  TopologyEditor editor(topology, seed, std::move(types));
  SerialExecutor executor;
  SimplexComplex kept;
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    kept.update(topology, executor);
    SimplexComplex fresh;
    fresh.update(topology, executor);
    ASSERT_EQ(kept.topology().mesh().element_count(), fresh.topology().mesh().element_count());
    ASSERT_EQ(kept.topology().features().triangle_count(), fresh.topology().features().triangle_count());
    expect_features_of_mesh(topology.features(), kept.topology().features());
    expect_mapped(kept, topology.features());
    if (testing::Test::HasFailure()) return;
    for (std::uint64_t edits = editor.random().below(3); edits > 0; --edits) editor.edit_at_random();
  }
}

TEST(SimplexComplex, FollowsEditsOfHexahedra) {
  expect_follows(block(ElementType::hexahedron, 4, 3, 2).mesh(), {ElementType::hexahedron}, 1);
}
TEST(SimplexComplex, FollowsEditsOfMixedElements) {
  for (std::uint64_t seed = 2; seed < 6; ++seed)
    expect_follows(permuted(mixed_block(2, 2), seed).mesh(),
                   {ElementType::hexahedron, ElementType::polytope, ElementType::tetrahedron, ElementType::quad,
                    ElementType::wedge, ElementType::triangle},
                   seed);
}

// A tetrahedron with a fin: two equal triangles at its first vertex, which no tetrahedron of the fan has.
TEST(SimplexComplex, HasTrianglesOfDegeneratePolytopes) {
  Mesh mesh;
  mesh.add_vertices(6);
  mesh.add_element({ElementType::polytope,
                    {0, 1, 2, 3, 4, 5},
                    {3, 0, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 3, 2, 3, 0, 4, 5, 3, 0, 5, 4},
                    0,
                    0});
  const Topology topology(std::move(mesh));
  SerialExecutor executor;
  SimplexComplex complex;
  complex.update(topology, executor);
  expect_features_of_mesh(topology.features(), complex.topology().features());
  expect_mapped(complex, topology.features());
}

}  // namespace
}  // namespace volccd::detail
