// The tables of a topology do not depend on the number of threads that build it.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "mesh/naive_features.hpp"

namespace volccd {
namespace {

using Numbers = std::vector<Index>;

void append(Numbers& all, std::span<const Index> list) {
  all.push_back(static_cast<Index>(list.size()));
  all.insert(all.end(), list.begin(), list.end());
}

Numbers vertex_table(const Topology& topology) {
  const Features& features = topology.features();
  Numbers all = {features.vertex_slots(), features.vertex_count(), topology.objects_share_vertices()};
  for (Index v = 0; v < features.vertex_slots(); ++v) {
    append(all, features.vertex_elements(v));
    all.push_back(features.first_element_of_vertex(v));
  }
  return all;
}

Numbers edge_table(const Topology& topology) {
  const Features& features = topology.features();
  Numbers all = {features.edge_slots(), features.edge_count()};
  for (Index e = 0; e < features.edge_slots(); ++e) {
    const auto& edge = features.edge(e);
    append(all, edge);
    append(all, features.edge_elements(e));
    all.insert(all.end(), {features.first_element_of_edge(e), features.find_edge(edge[0], edge[1])});
  }
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    append(all, features.element_edges(o));
    append(all, features.own_edges(o));
  }
  return all;
}

Numbers triangle_table(const Topology& topology) {
  const Features& features = topology.features();
  Numbers all = {features.triangle_slots(), features.triangle_count()};
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    const auto& t = features.triangle(f);
    append(all, t);
    append(all, features.triangle_elements(f));
    all.insert(all.end(), {features.first_element_of_triangle(f), features.find_triangle(t[0], t[1], t[2])});
  }
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    append(all, features.element_triangles(o));
    append(all, features.own_triangles(o));
  }
  return all;
}

Numbers adjacency_table(const Topology& topology) {
  Numbers all;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) append(all, topology.adjacency().vertices(o));
  return all;
}

class TopologyThreads : public testing::Test {
 protected:
  /// Compares the topologies that 3 and 8 threads build with that of the calling thread.
  void compare(const Mesh& mesh, EdgeSet edge_set, const std::string& name) {
    const Topology expected(mesh, edge_set);
    const Numbers vertices = vertex_table(expected), edges = edge_table(expected), triangles = triangle_table(expected),
                  adjacency = adjacency_table(expected);
    for (const auto& executor : executors_) {
      const Topology built(mesh, *executor, edge_set);
      const std::string text = name + ", threads: " + std::to_string(executor->workers());
      EXPECT_TRUE(vertex_table(built) == vertices) << text;
      EXPECT_TRUE(edge_table(built) == edges) << text;
      EXPECT_TRUE(triangle_table(built) == triangles) << text;
      EXPECT_TRUE(adjacency_table(built) == adjacency) << text;
      EXPECT_EQ(built.bytes(), expected.bytes()) << text;
    }
  }
  void compare(const Mesh& mesh, const std::string& name) {
    compare(mesh, EdgeSet::triangulated, name);
    compare(mesh, EdgeSet::polytope, name);
  }

 private:
  std::vector<std::unique_ptr<Executor>> executors_ = [] {
    std::vector<std::unique_ptr<Executor>> executors;
    for (const unsigned threads : {3u, 8u}) executors.push_back(make_thread_executor(threads));
    return executors;
  }();
};

/// A prism over a regular polygon, as one polytope.
ElementSpec prism(Index sides, Index first_vertex, std::int64_t id) {
  ElementSpec element;
  element.type = ElementType::polytope;
  element.id = id;
  for (Index i = 0; i < 2 * sides; ++i) element.vertices.push_back(first_vertex + i);
  for (const Index side : {first_vertex, first_vertex + sides}) {
    element.faces.push_back(sides);
    for (Index i = 0; i < sides; ++i) element.faces.push_back(side + i);
  }
  for (Index i = 0; i < sides; ++i) {
    const Index a = first_vertex + i, b = first_vertex + (i + 1) % sides;
    for (const Index x : {Index{4}, a, b, b + sides, a + sides}) element.faces.push_back(x);
  }
  return element;
}

TEST_F(TopologyThreads, SameTablesForEveryElementType) {
  for (const ElementType type :
       {ElementType::triangle, ElementType::quad, ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
        ElementType::hexahedron, ElementType::polytope}) {
    const bool shells = is_shell(type);
    compare(block(type, 3, 2, 2).mesh(), to_string(type));
    compare(permuted(block(type, shells ? 60 : 16, shells ? 50 : 9, 9), 3).mesh(), to_string(type));
  }
  compare(Mesh(), "no element");
}

TEST_F(TopologyThreads, SameTablesForMixedTypesAndObjects) {
  Shape shape = mixed_block(12, 11);
  for (std::size_t i = 0; i < shape.elements.size(); ++i) shape.elements[i].object = static_cast<std::int32_t>(i % 3);
  compare(shape.mesh(), "mixed");
  Mesh mesh = permuted(shape, 5).mesh();
  compare(mesh, "mixed, scattered");
  Random random(1);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (random.below(3) == 0) mesh.remove_element(o);
  compare(mesh, "mixed, with empty slots");
}

TEST_F(TopologyThreads, SameTablesForLargePolytopes) {
  // From 3 to 12 sides, in a chain: neighbours share the vertices in which their ranges overlap.
  Mesh mesh;
  mesh.add_vertices(12000);
  Index vertex = 0;
  for (Index o = 0; vertex + 24 < mesh.vertex_count(); ++o, vertex += 5) mesh.add_element(prism(3 + o % 10, vertex, o));
  compare(mesh, "prisms");
}

TEST_F(TopologyThreads, SameTablesForManyChunks) {
  const Shape shape = block(ElementType::tetrahedron, 14, 14, 14);
  compare(shape.mesh(), EdgeSet::triangulated, "in order");
  const Mesh mesh = permuted(shape, 9).mesh();
  compare(mesh, EdgeSet::triangulated, "scattered");
  EXPECT_EQ(test::inconsistency(mesh, Topology(mesh).features()), "");
}

TEST_F(TopologyThreads, SameTablesForUnevenUseOfVertices) {
  Random random(2);
  for (const Index common : {1u, 20u}) {  // many elements at few vertices, or few elements on many vertices
    Mesh mesh;
    mesh.add_vertices(common == 1 ? 400000 : 5000);
    for (Index o = 0; o < (common == 1 ? 500u : 8000u); ++o) {
      ElementSpec element{.type = ElementType::tetrahedron, .id = o};
      if (common != 1) element.vertices.push_back(static_cast<Index>(random.below(common)));
      while (element.vertices.size() < 4) {
        const Index v = static_cast<Index>(common + random.below(mesh.vertex_count() - common));
        if (std::find(element.vertices.begin(), element.vertices.end(), v) == element.vertices.end())
          element.vertices.push_back(v);
      }
      mesh.add_element(element);
    }
    compare(mesh, EdgeSet::triangulated, std::to_string(common));
    EXPECT_EQ(test::inconsistency(mesh, Topology(mesh).features()), "");
  }
}

}  // namespace
}  // namespace volccd
