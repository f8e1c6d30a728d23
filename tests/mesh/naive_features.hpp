// Features by simple enumeration: sets of vertex tuples, from face lists that are independent of the library's.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include <volccd/mesh/features.hpp>

namespace volccd::test {

using Edge = std::array<Index, 2>;
using Triangle = std::array<Index, 3>;
using Elements = std::set<Index>;

struct NaiveFeatures {
  std::map<Index, Elements> vertices;
  std::map<Edge, Elements> edges;
  std::map<Triangle, Elements> triangles;
  bool operator==(const NaiveFeatures&) const = default;
};

/// Faces of an element as polygons of vertex slots.
inline std::vector<std::vector<Index>> faces_of(const Mesh& mesh, Index o) {
  static const std::map<ElementType, std::vector<std::vector<int>>> kFaces = {
      {ElementType::triangle, {{0, 1, 2}}},
      {ElementType::quad, {{0, 1, 2, 3}}},
      {ElementType::tetrahedron, {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}},
      {ElementType::pyramid, {{0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}},
      {ElementType::wedge, {{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
      {ElementType::hexahedron, {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}};
  std::vector<std::vector<Index>> faces;
  if (mesh.type(o) == ElementType::polytope) {
    const auto stream = mesh.polytope_faces(o);
    for (std::size_t at = 0; at < stream.size(); at += stream[at] + 1u)
      faces.emplace_back(stream.begin() + static_cast<std::ptrdiff_t>(at + 1),
                         stream.begin() + static_cast<std::ptrdiff_t>(at + 1 + stream[at]));
    return faces;
  }
  for (const auto& face : kFaces.at(mesh.type(o))) {
    faces.emplace_back();
    for (int i : face) faces.back().push_back(mesh.vertices(o)[static_cast<std::size_t>(i)]);
  }
  return faces;
}

inline NaiveFeatures naive_features(const Mesh& mesh, EdgeSet edge_set) {
  NaiveFeatures all;
  const auto sorted = [](auto tuple) {
    std::sort(tuple.begin(), tuple.end());
    return tuple;
  };
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    for (Index v : mesh.vertices(o)) all.vertices[v].insert(o);
    if (edge_set == EdgeSet::none) continue;
    for (const auto& face : faces_of(mesh, o)) {
      const std::size_t n = face.size();
      const auto smallest = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
      for (std::size_t i = 0; i < n; ++i) {
        all.edges[sorted(Edge{face[i], face[(i + 1) % n]})].insert(o);
        const std::size_t j = (i + 1) % n;
        if (edge_set == EdgeSet::triangulated && i != smallest)
          all.edges[sorted(Edge{face[smallest], face[i]})].insert(o);
        if (i != smallest && j != smallest) all.triangles[sorted(Triangle{face[smallest], face[i], face[j]})].insert(o);
      }
    }
  }
  return all;
}

inline Elements as_set(std::span<const Index> list) { return Elements(list.begin(), list.end()); }

/// The contents of a Features object in the same form, live features only.
inline NaiveFeatures contents(const Features& features) {
  NaiveFeatures all;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty()) all.vertices[v] = as_set(features.vertex_elements(v));
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty()) all.edges[features.edge(e)] = as_set(features.edge_elements(e));
  for (Index f = 0; f < features.triangle_slots(); ++f)
    if (!features.triangle_elements(f).empty())
      all.triangles[features.triangle(f)] = as_set(features.triangle_elements(f));
  return all;
}

/// Checks all invariants of Features, and of Features and Mesh together. Returns an empty string if they hold.
inline std::string inconsistency(const Mesh& mesh, const Features& features) {
  const NaiveFeatures found = contents(features), naive = naive_features(mesh, features.edge_set());
  if (found.vertices != naive.vertices) return "vertices differ";
  if (found.edges != naive.edges) return "edges differ";
  if (found.triangles != naive.triangles) return "triangles differ";
  if (features.vertex_slots() != mesh.vertex_count()) return "number of vertex slots";
  if (features.vertex_count() != naive.vertices.size()) return "vertex_count";
  if (features.edge_count() != naive.edges.size()) return "edge_count: an edge has two slots, or the count is off";
  if (features.triangle_count() != naive.triangles.size()) return "triangle_count";
  const auto ascends = [](std::span<const Index> list) {
    return std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end();
  };
  std::map<Index, std::multiset<Index>> edges_of, triangles_of;
  for (Index e = 0; e < features.edge_slots(); ++e) {
    if (!ascends(features.edge_elements(e))) return "elements of an edge do not ascend";
    for (Index o : features.edge_elements(e)) edges_of[o].insert(e);
    const auto [a, b] = features.edge(e);
    if (!features.edge_elements(e).empty() &&
        (features.find_edge(a, b) != e || features.find_edge(b, a) != e || a >= b))
      return "find_edge";
  }
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    if (!ascends(features.triangle_elements(f))) return "elements of a triangle do not ascend";
    for (Index o : features.triangle_elements(f)) triangles_of[o].insert(f);
    const auto [a, b, c] = features.triangle(f);
    if (!features.triangle_elements(f).empty() &&
        (features.find_triangle(a, b, c) != f || features.find_triangle(c, a, b) != f || a >= b || b >= c))
      return "find_triangle";
  }
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!ascends(features.vertex_elements(v))) return "elements of a vertex do not ascend";
  // For each element, the features of which it is the first element.
  const auto first = [](std::span<const Index> elements) { return elements.empty() ? kNone : elements.front(); };
  std::map<Index, std::vector<Index>> own_edges, own_triangles;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (features.first_element_of_vertex(v) != first(features.vertex_elements(v))) return "first_element_of_vertex";
  for (Index e = 0; e < features.edge_slots(); ++e) {
    if (features.first_element_of_edge(e) != first(features.edge_elements(e))) return "first_element_of_edge";
    own_edges[features.first_element_of_edge(e)].push_back(e);
  }
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    if (features.first_element_of_triangle(f) != first(features.triangle_elements(f)))
      return "first_element_of_triangle";
    own_triangles[features.first_element_of_triangle(f)].push_back(f);
  }
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    const auto edges = features.element_edges(o), triangles = features.element_triangles(o);
    if (std::multiset<Index>(edges.begin(), edges.end()) != edges_of[o]) return "element_edges";
    if (std::multiset<Index>(triangles.begin(), triangles.end()) != triangles_of[o]) return "element_triangles";
    if (!std::ranges::equal(features.own_edges(o), own_edges[o])) return "own_edges";
    if (!std::ranges::equal(features.own_triangles(o), own_triangles[o])) return "own_triangles";
  }
  return {};
}

}  // namespace volccd::test
