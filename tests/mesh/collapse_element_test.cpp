// Elements with repeated nodes: for each type and each way to identify nodes, compares the faces that remain.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include <Eigen/Geometry>

#include <volccd/mesh/check_element.hpp>
#include <volccd/mesh/collapse_element.hpp>

namespace volccd::detail {
namespace {

using Nodes = std::vector<Index>;

/// A triangulated, oriented surface as a chain: for each triangle (ascending vertices), how often it occurs minus how
/// often the reversed triangle occurs. Quads are split by the diagonal through their smallest node, as in Features.
using Chain = std::map<std::array<Index, 3>, int>;

void add_triangle(Index a, Index b, Index c, Chain& chain) {
  if (a == b || b == c || c == a) return;
  std::array<Index, 3> key{a, b, c};
  std::sort(key.begin(), key.end());
  const bool even = (a == key[0] && b == key[1]) || (b == key[0] && c == key[1]) || (c == key[0] && a == key[1]);
  if ((chain[key] += even ? 1 : -1) == 0) chain.erase(key);
}

void add_face(const Nodes& face, Chain& chain) {
  const std::size_t n = face.size();
  const std::size_t s = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
  for (std::size_t i = 1; i + 1 < n; ++i) add_triangle(face[s], face[(s + i) % n], face[(s + i + 1) % n], chain);
}

Chain chain_of(ElementType type, const Nodes& nodes) {
  Chain chain;
  const auto stream = face_stream(type);
  for (std::size_t at = 0; at < stream.size(); at += stream[at] + 1u) {
    Nodes face;
    for (std::size_t i = 1; i <= stream[at]; ++i) face.push_back(nodes[stream[at + i]]);
    add_face(face, chain);
  }
  return chain;
}

Chain chain_of(const CollapsedElement& element) {
  if (element.type != ElementType::polytope) return chain_of(element.type, element.vertices);
  Chain chain;
  for (std::size_t at = 0; at < element.faces.size(); at += element.faces[at] + 1u)
    add_face({element.faces.begin() + static_cast<std::ptrdiff_t>(at) + 1,
              element.faces.begin() + static_cast<std::ptrdiff_t>(at + 1 + element.faces[at])},
             chain);
  return chain;
}

/// All ways to identify n nodes. Each node has the number of the first member of its group.
void for_each_identification(std::size_t n, const std::function<void(const Nodes&)>& visit) {
  Nodes nodes;
  const std::function<void()> go = [&] {
    if (nodes.size() == n) return visit(nodes);
    const Index own = static_cast<Index>(nodes.size());
    for (Index first = 0; first <= own; ++first) {
      if (first < own && nodes[first] != first) continue;
      nodes.push_back(first);
      go();
      nodes.pop_back();
    }
  };
  go();
}

bool is_tetrahedron_of_ls_dyna(ElementType type, const Nodes& n) {
  return type == ElementType::hexahedron && n == Nodes{0, 1, 2, 3, 3, 3, 3, 3};
}

TEST(CollapseElement, EveryIdentificationKeepsTheBoundaryOrIsRefused) {
  const std::map<ElementType, std::size_t> all = {{ElementType::tetrahedron, 15},
                                                  {ElementType::pyramid, 52},
                                                  {ElementType::wedge, 203},
                                                  {ElementType::hexahedron, 4140}};  // Bell numbers
  for (const auto& [of, many] : all) {
    const ElementType type = of;  // clang cannot capture structured bindings
    const std::size_t count = many;
    std::size_t seen = 0;
    std::map<ElementType, int> results;
    for_each_identification(static_cast<std::size_t>(vertex_count(type)), [&](const Nodes& nodes) {
      if (++seen == count) return;  // the last way identifies no nodes
      const CollapsedElement element = collapse_element(type, nodes);
      ++results[element.type];
      std::string text = to_string(type);
      for (const Index v : nodes) text += " " + std::to_string(v);
      if (element.type == ElementType::none) {
        EXPECT_FALSE(element.problem.empty()) << text;
        return;
      }
      Nodes distinct = nodes, vertices = element.vertices;
      std::sort(distinct.begin(), distinct.end());
      distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
      std::sort(vertices.begin(), vertices.end());
      EXPECT_EQ(vertices, distinct) << text;
      EXPECT_EQ(element_problem({element.type, element.vertices, element.faces, 0, 0}, 8), "") << text;
      if (!is_tetrahedron_of_ls_dyna(type, nodes)) {
        EXPECT_EQ(chain_of(element), chain_of(type, nodes)) << text;
      }
    });
    EXPECT_EQ(seen, count);
    // Collapses of two opposite edges of a face; of an edge between the triangles of a wedge; of an edge of a pyramid's
    // base.
    if (type == ElementType::hexahedron) {
      EXPECT_EQ(results[ElementType::wedge], 12);
    }
    if (type == ElementType::wedge) {
      EXPECT_EQ(results[ElementType::pyramid], 3);
    }
    if (type == ElementType::pyramid) {
      EXPECT_EQ(results[ElementType::tetrahedron], 4);
    }
  }
}

struct Collapse {
  const char* name;
  ElementType type;
  Nodes nodes;
  ElementType result;
  Nodes vertices;
};

/// The collapses that finite-element programs document, with the resulting node order.
TEST(CollapseElement, DocumentedCollapses) {
  using enum ElementType;
  const Collapse collapses[] = {
      {"LS-DYNA: wedge, n5 = n6, n7 = n8", hexahedron, {0, 1, 2, 3, 4, 4, 6, 6}, wedge, {0, 1, 4, 3, 2, 6}},
      {"Abaqus, Nastran: wedge, n3 = n4, n7 = n8", hexahedron, {0, 1, 2, 2, 4, 5, 6, 6}, wedge, {0, 2, 1, 4, 6, 5}},
      {"wedge, n1 = n2, n5 = n6", hexahedron, {0, 0, 2, 3, 4, 4, 6, 7}, wedge, {0, 3, 2, 4, 7, 6}},
      {"pyramid, n5 = .. = n8", hexahedron, {0, 1, 2, 3, 4, 4, 4, 4}, pyramid, {0, 1, 2, 3, 4}},
      {"LS-DYNA: tetrahedron, n4 = .. = n8", hexahedron, {0, 1, 2, 3, 3, 3, 3, 3}, tetrahedron, {0, 1, 2, 3}},
      {"tetrahedron, n3 = n4, n5 = .. = n8", hexahedron, {0, 1, 2, 2, 4, 4, 4, 4}, tetrahedron, {0, 1, 2, 4}},
      {"tetrahedron from wedge, n4 = n5 = n6", wedge, {0, 1, 2, 3, 3, 3}, tetrahedron, {0, 2, 1, 3}},
      {"pyramid from wedge, n1 = n4", wedge, {0, 1, 2, 0, 4, 5}, pyramid, {1, 2, 5, 4, 0}},
      {"tetrahedron from pyramid, n3 = n4", pyramid, {0, 1, 2, 2, 4}, tetrahedron, {0, 1, 2, 4}},
      {"triangle, n3 = n4", quad, {0, 1, 2, 2}, triangle, {0, 1, 2}},
      {"triangle, n4 = n1", quad, {0, 1, 2, 0}, triangle, {0, 1, 2}},
      {"triangle, n1 = n2", quad, {0, 0, 2, 3}, triangle, {0, 2, 3}},
      {"triangle, n2 = n3", quad, {0, 1, 1, 3}, triangle, {0, 1, 3}}};
  for (const Collapse& c : collapses) {
    const CollapsedElement element = collapse_element(c.type, c.nodes);
    EXPECT_EQ(element.type, c.result) << c.name;
    ASSERT_EQ(element.vertices.size(), c.vertices.size()) << c.name;
    // The same oriented boundary and, for shells, the same orientation mean the same element, whichever node is the
    // first.
    if (is_shell(c.type))
      EXPECT_EQ(element.vertices, c.vertices) << c.name;
    else
      EXPECT_EQ(chain_of(element), chain_of(c.result, c.vertices)) << c.name;
  }
}

/// Each element to which a cube collapses keeps its orientation: no volume at a corner is negative.
TEST(CollapseElement, VolumeStaysPositive) {
  const Vec3 x[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.2, .2, 1}, {.8, .2, 1}, {.8, .8, 1}, {.2, .8, 1}};
  const Nodes collapses[] = {{0, 1, 2, 3, 4, 4, 6, 6}, {0, 1, 2, 2, 4, 5, 6, 6}, {0, 0, 2, 3, 4, 4, 6, 7},
                             {0, 1, 2, 3, 4, 4, 4, 4}, {0, 1, 2, 2, 4, 4, 4, 4}, {0, 1, 2, 3, 4, 5, 6, 6},
                             {0, 1, 2, 2, 4, 5, 6, 7}};
  for (const Nodes& nodes : collapses) {
    const CollapsedElement element = collapse_element(ElementType::hexahedron, nodes);
    double volume = 0;
    for (const auto& [t, sign] : chain_of(element)) volume += sign * x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6;
    EXPECT_GT(volume, 0.05) << to_string(element.type);
  }
}

TEST(CollapseElement, ASolidWithOneShortEdgeIsAPolytope) {
  const CollapsedElement element = collapse_element(ElementType::hexahedron, Nodes{0, 1, 2, 3, 0, 5, 6, 7});
  EXPECT_EQ(element.type, ElementType::polytope);
  EXPECT_EQ(element.vertices.size(), 7u);
}

TEST(CollapseElement, RefusesWhatIsNoElement) {
  using enum ElementType;
  const std::pair<ElementType, Nodes> bad[] = {{hexahedron, {0, 1, 2, 3, 0, 1, 2, 3}},  // a sheet
                                               {hexahedron, {0, 1, 2, 3, 4, 5, 0, 7}},  // opposite corners
                                               {hexahedron, {0, 0, 0, 0, 0, 0, 0, 0}},
                                               {hexahedron, {0, 1, 1, 0, 0, 1, 1, 0}},
                                               {wedge, {0, 1, 2, 0, 1, 2}},
                                               {wedge, {0, 0, 0, 3, 3, 3}},
                                               {pyramid, {0, 1, 2, 3, 0}},
                                               {pyramid, {0, 1, 0, 3, 4}},
                                               {tetrahedron, {0, 1, 2, 2}},
                                               {quad, {0, 1, 0, 3}},
                                               {quad, {0, 0, 1, 1}},
                                               {quad, {0, 1, 1, 0}},
                                               {triangle, {0, 1, 1}}};
  for (const auto& [type, nodes] : bad) {
    const CollapsedElement element = collapse_element(type, nodes);
    EXPECT_EQ(element.type, none) << to_string(type);
    EXPECT_FALSE(element.problem.empty());
  }
}

}  // namespace
}  // namespace volccd::detail
