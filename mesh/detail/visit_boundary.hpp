// The triangulated boundary of an element; see mesh/features.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/detail/element_tables.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd {

namespace detail {

/// Edges and triangles of a polytope. Each tuple is ascending, each list is ascending and without duplicates: in a
/// degenerate polytope the diagonal of one face may be an edge or a diagonal of another face, and two triangles may
/// coincide.
struct PolytopeBoundary {
  PolytopeBoundary(std::span<const Index> faces, EdgeSet edge_set);

  std::vector<std::array<Index, 2>> edges;
  std::vector<std::array<Index, 3>> triangles;
};

/// The vertices of a quad in cyclic order, beginning with the smallest slot: the diagonal is 0-2, the triangles are
/// 0-1-2 and 0-2-3.
inline std::array<Index, 4> rotate_to_smallest(const Index* v, const std::array<std::uint8_t, 4>& quad) {
  std::array<Index, 4> q{v[quad[0]], v[quad[1]], v[quad[2]], v[quad[3]]};
  std::rotate(q.begin(), std::min_element(q.begin(), q.end()), q.end());
  return q;
}

inline std::array<Index, 2> ascending(Index a, Index b) { return a < b ? std::array{a, b} : std::array{b, a}; }

inline std::array<Index, 3> ascending(Index a, Index b, Index c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

/// The same for an element with vertices v; `faces` is the face stream if it is a polytope.
template <class EdgeVisitor, class TriangleVisitor>
void visit_boundary(ElementType type, const Index* v, std::span<const Index> faces, EdgeSet edge_set,
                    EdgeVisitor&& edge, TriangleVisitor&& triangle) {
  if (edge_set == EdgeSet::none) return;
  if (type == ElementType::polytope) {
    const PolytopeBoundary boundary(faces, edge_set);
    for (const auto& e : boundary.edges) edge(e[0], e[1]);
    for (const auto& f : boundary.triangles) triangle(f[0], f[1], f[2]);
    return;
  }
  // The vertices are distinct, so that no diagonal of a fixed type coincides with an edge or another diagonal.
  const ElementTable& table = element_table(type);
  for (std::size_t i = 0; i < table.edges; ++i) edge(v[table.edge[i][0]], v[table.edge[i][1]]);
  for (std::size_t i = 0; i < table.triangles; ++i)
    triangle(v[table.triangle[i][0]], v[table.triangle[i][1]], v[table.triangle[i][2]]);
  for (std::size_t i = 0; i < table.quads; ++i) {
    const std::array<Index, 4> q = rotate_to_smallest(v, table.quad[i]);
    if (edge_set == EdgeSet::triangulated) edge(q[0], q[2]);
    triangle(q[0], q[1], q[2]);
    triangle(q[0], q[2], q[3]);
  }
}

}  // namespace detail

template <class EdgeVisitor, class TriangleVisitor>
void visit_boundary(const Mesh& mesh, Index o, EdgeSet edge_set, EdgeVisitor&& edge, TriangleVisitor&& triangle) {
  detail::visit_boundary(mesh.type(o), mesh.vertices(o).data(), mesh.polytope_faces(o), edge_set, edge, triangle);
}

}  // namespace volccd
