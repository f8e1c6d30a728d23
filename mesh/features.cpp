#include <volccd/mesh/features.hpp>

#include <algorithm>
#include <atomic>

#include <volccd/core/sort_unique.hpp>
#include <volccd/mesh/tables/chunks.hpp>
#include <volccd/mesh/tables/group_by_key.hpp>
#include <volccd/mesh/tables/number_tuples.hpp>

namespace volccd {

namespace detail {

PolytopeBoundary::PolytopeBoundary(std::span<const Index> faces, EdgeSet edge_set) {
  std::vector<Index> face;
  visit_faces(faces, [&](std::span<const Index> stored) {
    face.assign(stored.begin(), stored.end());
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    const std::size_t n = face.size();
    for (std::size_t i = 0; i < n; ++i) edges.push_back(ascending(face[i], face[(i + 1) % n]));
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const auto [low, high] = std::minmax(face[i], face[i + 1]);
      triangles.push_back({face[0], low, high});
      if (edge_set == EdgeSet::triangulated && i != 1) edges.push_back({face[0], face[i]});
    }
  });
  sort_unique(edges);
  sort_unique(triangles);
}

}  // namespace detail

namespace {

using detail::ascending;

/// Upper bounds on the numbers of edges and triangles of some elements, with repetition.
std::array<std::size_t, 2> boundary_sizes(const Mesh& mesh, std::size_t begin, std::size_t end, EdgeSet edge_set) {
  std::size_t edges = 0, triangles = 0;
  if (edge_set == EdgeSet::none) return {edges, triangles};
  for (Index o = static_cast<Index>(begin); o < end; ++o) {
    const detail::ElementTable& table = detail::element_table(mesh.type(o));
    const std::size_t faces = mesh.type(o) == ElementType::polytope ? mesh.polytope_faces(o).size() : 0;
    edges += table.edges + (edge_set == EdgeSet::triangulated ? table.quads : 0u) + faces;
    triangles += table.triangles + 2u * table.quads + faces;
  }
  return {edges, triangles};
}

/// Lists the boundaries of all elements.
void list_boundaries(const Mesh& mesh, EdgeSet edge_set, Executor& executor, detail::Occurrences<2>& edges,
                     detail::Occurrences<3>& triangles) {
  const detail::Chunks chunks(mesh.element_slots());
  std::vector<std::size_t> max_edges(chunks.count()), max_triangles(chunks.count());
  chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
    const auto [edge_count, triangle_count] = boundary_sizes(mesh, begin, end, edge_set);
    max_edges[c] = edge_count;
    max_triangles[c] = triangle_count;
  });
  edges.allocate(mesh.element_slots(), max_edges);
  triangles.allocate(mesh.element_slots(), max_triangles);
  chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
    std::array<Index, 2>* edge = edges.tuples.data() + edges.begin[c];
    std::array<Index, 3>* triangle = triangles.tuples.data() + triangles.begin[c];
    for (Index o = static_cast<Index>(begin); o < end; ++o) {
      const std::array<Index, 2>* const first_edge = edge;
      const std::array<Index, 3>* const first_triangle = triangle;
      if (mesh.is_live(o))
        visit_boundary(
            mesh, o, edge_set, [&](Index v0, Index v1) { *edge++ = ascending(v0, v1); },
            [&](Index v0, Index v1, Index v2) { *triangle++ = ascending(v0, v1, v2); });
      edges.lengths[o] = static_cast<Index>(edge - first_edge);
      triangles.lengths[o] = static_cast<Index>(triangle - first_triangle);
    }
  });
}

/// Sets the incident elements of all vertices. Returns the number of live vertices.
Index build_vertices(const Mesh& mesh, Executor& executor, detail::Incidence& incidence) {
  const auto add_vertices = [&](std::size_t, std::size_t begin, std::size_t end, auto&& add) {
    for (Index o = static_cast<Index>(begin); o < end; ++o)
      for (const Index v : mesh.vertices(o)) add(detail::KeyValue{v, o});
  };
  detail::group_by_key(mesh.element_slots(), mesh.vertex_count(), std::size_t{4} * mesh.element_slots(), executor,
                       add_vertices, incidence.elements);
  detail::resize_with_spare(incidence.first, mesh.vertex_count());
  std::atomic<Index> live{0};
  detail::Chunks(mesh.vertex_count()).for_each(executor, [&](std::size_t, std::size_t begin, std::size_t end) {
    Index count = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const std::span<const Index> elements = incidence.elements[v];
      incidence.first[v] = elements.empty() ? kNone : elements.front();
      count += !elements.empty();
    }
    live += count;
  });
  return live;
}

/// Builds the edges or the triangles from their occurrences, whose memory it releases.
template <std::size_t N>
void build_kind(detail::Occurrences<N>& occurrences, const Mesh& mesh, Executor& executor,
                detail::TupleFeatures<N>& features) {
  detail::number_tuples(occurrences, mesh.vertex_count(), executor, features);
  features.table.fill(features.tuples, executor);
  const auto add_features = [&](std::size_t, std::size_t begin, std::size_t end, auto&& add) {
    for (Index i = static_cast<Index>(begin); i < end; ++i) add(detail::KeyValue{features.incidence.first[i], i});
  };
  const std::size_t count = features.tuples.size();
  detail::group_by_key(count, mesh.element_slots(), count, executor, add_features, features.incidence.own);
}

}  // namespace

void Features::build(const Mesh& mesh, Executor& executor) {
  *this = Features(edge_set_);
  live_vertices_ = build_vertices(mesh, executor, vertex_incidence_);
  detail::Occurrences<2> edges;
  detail::Occurrences<3> triangles;
  list_boundaries(mesh, edge_set_, executor, edges, triangles);
  build_kind(edges, mesh, executor, edges_);
  build_kind(triangles, mesh, executor, triangles_);
}

Index Features::find_edge(Index v0, Index v1) const { return edges_.table.find(ascending(v0, v1), edges_.tuples); }

Index Features::find_triangle(Index v0, Index v1, Index v2) const {
  return triangles_.table.find(ascending(v0, v1, v2), triangles_.tuples);
}

std::vector<std::array<Index, 3>> oriented_boundary(const Mesh& mesh, Index o) {
  std::vector<std::array<Index, 3>> triangles;
  const auto add = [&](Index a, Index b, Index c) { triangles.push_back({a, b, c}); };
  if (mesh.type(o) != ElementType::polytope)  // the triangles of fixed types are oriented as their faces
    visit_boundary(
        mesh, o, EdgeSet::triangulated, [](Index, Index) {}, add);
  visit_faces(mesh.polytope_faces(o), [&](std::span<const Index> stored) {
    std::vector<Index> face(stored.begin(), stored.end());
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    for (std::size_t i = 1; i + 1 < face.size(); ++i) add(face[0], face[i], face[i + 1]);
  });
  return triangles;
}

}  // namespace volccd
