#include <volccd/mesh/features.hpp>

#include <algorithm>

#include <volccd/core/sort_unique.hpp>
#include <volccd/mesh/detail/number_tuples.hpp>

namespace volccd {

namespace detail {

PolytopeBoundary::PolytopeBoundary(std::span<const Index> faces, EdgeSet edge_set) {
  std::vector<Index> face;
  visit_faces(faces, [&](std::span<const Index> stored) {
    face.assign(stored.begin(), stored.end());
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    const std::size_t n = face.size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto [low, high] = std::minmax(face[i], face[(i + 1) % n]);
      edges.push_back({low, high});
    }
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

/// Upper bounds on the numbers of features of all elements, with repetition.
struct BoundarySize {
  std::size_t edges = 0, triangles = 0;
};

BoundarySize boundary_size(const Mesh& mesh, EdgeSet edge_set) {
  BoundarySize size;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    const detail::ElementTable& table = detail::element_table(mesh.type(o));
    size.edges += table.edges + (edge_set == EdgeSet::triangulated ? table.quads : 0u);
    size.triangles += table.triangles + 2u * table.quads;
    if (mesh.type(o) == ElementType::polytope) {
      size.edges += mesh.polytope_faces(o).size();
      size.triangles += mesh.polytope_faces(o).size();
    }
  }
  return size;
}

void fill_first(detail::Incidence& incidence) {
  const std::size_t features = incidence.elements.size();
  incidence.first.reserve(detail::with_spare(features));
  for (std::size_t i = 0; i < features; ++i)
    incidence.first.push_back(incidence.elements[i].empty() ? kNone : incidence.elements[i].front());
}

/// Builds the tables of the edges or the triangles from their occurrences.
template <std::size_t N>
void build_kind(const detail::Occurrences<N>& occurrences, const Mesh& mesh, std::vector<std::array<Index, N>>& tuples,
                detail::TupleTable<N>& table, detail::Incidence& incidence, detail::IncidencePool& of_element) {
  of_element.clear(mesh.element_slots(), occurrences.tuples.size());
  std::vector<Index> numbers;
  detail::number_tuples(occurrences, mesh.vertex_count(), tuples, incidence.elements, numbers);
  for (std::size_t k = 0; k < numbers.size(); ++k) of_element.push_back(occurrences.elements[k], numbers[k]);
  table.fill(tuples);
  fill_first(incidence);
  std::vector<Index> lengths(mesh.element_slots());
  for (const Index o : incidence.first) ++lengths[o];
  incidence.own.layout(lengths);
  for (Index i = 0; i < incidence.first.size(); ++i) incidence.own.append(incidence.first[i], i);
}

}  // namespace

void Features::build(const Mesh& mesh) {
  *this = Features(edge_set_);
  const BoundarySize most = boundary_size(mesh, edge_set_);
  detail::Occurrences<2> edges;
  detail::Occurrences<3> triangles;
  edges.reserve(most.edges);
  triangles.reserve(most.triangles);
  std::vector<Index> vertex_lengths(mesh.vertex_count());
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    for (Index v : mesh.vertices(o)) ++vertex_lengths[v];
    visit_boundary(
        mesh, o, edge_set_, [&](Index a, Index b) { edges.add(ascending(a, b), o); },
        [&](Index a, Index b, Index c) { triangles.add(ascending(a, b, c), o); });
  }

  live_vertices_ =
      mesh.vertex_count() - static_cast<Index>(std::count(vertex_lengths.begin(), vertex_lengths.end(), Index{0}));
  vertex_incidence_.elements.layout(vertex_lengths);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    for (Index v : mesh.vertices(o)) vertex_incidence_.elements.append(v, o);
  fill_first(vertex_incidence_);

  build_kind(edges, mesh, edges_, edge_table_, edge_incidence_, element_edges_);
  edges = {};  // releases memory, because both at once would determine the peak of memory use
  build_kind(triangles, mesh, triangles_, triangle_table_, triangle_incidence_, element_triangles_);
}

Index Features::find_edge(Index v0, Index v1) const { return edge_table_.find(ascending(v0, v1), edges_); }

Index Features::find_triangle(Index v0, Index v1, Index v2) const {
  return triangle_table_.find(ascending(v0, v1, v2), triangles_);
}

std::size_t Features::bytes() const {
  std::size_t total = edges_.capacity() * sizeof(edges_[0]) + triangles_.capacity() * sizeof(triangles_[0]) +
                      edge_table_.bytes() + triangle_table_.bytes() + element_edges_.bytes() +
                      element_triangles_.bytes() +
                      (free_edges_.capacity() + free_triangles_.capacity()) * sizeof(Index);
  for (const auto* incidence : {&vertex_incidence_, &edge_incidence_, &triangle_incidence_})
    total += incidence->elements.bytes() + incidence->first.capacity() * sizeof(Index) + incidence->own.bytes();
  return total;
}

}  // namespace volccd
