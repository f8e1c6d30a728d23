#include <volccd/mesh/features.hpp>

#include <algorithm>
#include <cassert>

namespace volccd {

namespace detail {

namespace {

template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

PolytopeBoundary::PolytopeBoundary(std::span<const Index> faces, EdgeSet edge_set) {
  std::vector<Index> face;
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + 1u) {
    face.assign(faces.begin() + static_cast<std::ptrdiff_t>(at + 1),
                faces.begin() + static_cast<std::ptrdiff_t>(at + 1 + faces[at]));
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
  }
  sort_unique(edges);
  sort_unique(triangles);
}

}  // namespace detail

namespace {

std::array<Index, 2> ascending(Index a, Index b) { return a < b ? std::array{a, b} : std::array{b, a}; }

std::array<Index, 3> ascending(Index a, Index b, Index c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

/// Exact, but for a little room for the changes to come.
template <class T>
void trim(std::vector<T>& values) {
  std::vector<T> trimmed;
  trimmed.reserve(values.size() + values.size() / 16);
  trimmed.assign(values.begin(), values.end());
  values.swap(trimmed);
}

/// Slot for a new feature.
Index free_slot(const std::vector<Index>& free, std::size_t end) {
  return free.empty() ? static_cast<Index>(end) : free.back();
}

/// Sorted, without duplicates, and without features that have died since they were touched.
void settle_touched(std::vector<Index>& touched, const detail::IncidencePool& elements) {
  std::erase_if(touched, [&](Index i) { return elements[i].empty(); });
  detail::sort_unique(touched);
}

/// Upper estimate of the features of all elements, with repetition.
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

}  // namespace

void Features::build(const Mesh& mesh) {
  *this = Features(edge_set_);
  const BoundarySize total = boundary_size(mesh, edge_set_);
  element_edges_.clear(mesh.element_slots(), total.edges);
  element_triangles_.clear(mesh.element_slots(), total.triangles);
  // Inside a mesh a triangle has two elements, an edge about five.
  edge_table_.reserve(total.edges / 4, edges_);
  triangle_table_.reserve(total.triangles / 2 + total.triangles / 32, triangles_);

  // Numbers the features and counts their elements; then the lists are laid out exactly, and filled in ascending order.
  std::vector<Index> vertex_lengths(mesh.vertex_count()), edge_lengths, triangle_lengths;
  edge_lengths.reserve(total.edges / 4);
  triangle_lengths.reserve(total.triangles / 2);
  std::vector<Index> edges, triangles;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.alive(o)) continue;
    edges.clear();
    triangles.clear();
    for (Index v : mesh.vertices(o)) ++vertex_lengths[v];
    visit_boundary(
        mesh, o, edge_set_,
        [&](Index a, Index b) {
          const std::array<Index, 2> key = ascending(a, b);
          const Index e = edge_table_.find_or_insert(key, edge_slots(), edges_);
          if (e == edge_slots()) {
            edges_.push_back(key);
            edge_lengths.push_back(0);
          }
          ++edge_lengths[e];
          edges.push_back(e);
        },
        [&](Index a, Index b, Index c) {
          const std::array<Index, 3> key = ascending(a, b, c);
          const Index f = triangle_table_.find_or_insert(key, triangle_slots(), triangles_);
          if (f == triangle_slots()) {
            triangles_.push_back(key);
            triangle_lengths.push_back(0);
          }
          ++triangle_lengths[f];
          triangles.push_back(f);
        });
    element_edges_.assign(o, edges);
    element_triangles_.assign(o, triangles);
  }
  trim(edges_);
  trim(triangles_);
  live_vertices_ = static_cast<Index>(vertex_lengths.size()) -
                   static_cast<Index>(std::count(vertex_lengths.begin(), vertex_lengths.end(), 0u));
  live_edges_ = edge_slots();
  live_triangles_ = triangle_slots();

  vertex_elements_.layout(vertex_lengths);
  edge_elements_.layout(edge_lengths);
  triangle_elements_.layout(triangle_lengths);
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    for (Index v : mesh.vertices(o)) vertex_elements_.append(v, o);
    for (Index e : element_edges_[o]) edge_elements_.append(e, o);
    for (Index f : element_triangles_[o]) triangle_elements_.append(f, o);
  }
}

void Features::remove(const Mesh& mesh, std::span<const Index> elements, FeatureChange& change) {
  for (Index o : elements) erase_element(mesh, o, change);
  detail::sort_unique(change.removed_vertices);
  detail::sort_unique(change.removed_edges);
  detail::sort_unique(change.removed_triangles);
  settle_touched(change.touched_vertices, vertex_elements_);
  settle_touched(change.touched_edges, edge_elements_);
  settle_touched(change.touched_triangles, triangle_elements_);
}

void Features::add(const Mesh& mesh, std::span<const Index> elements, FeatureChange& change) {
  vertex_elements_.extend(mesh.vertex_count());
  element_edges_.extend(mesh.element_slots());
  element_triangles_.extend(mesh.element_slots());
  for (Index o : elements) insert_element(mesh, o, change);
  detail::sort_unique(change.added_vertices);
  detail::sort_unique(change.added_edges);
  detail::sort_unique(change.added_triangles);
  settle_touched(change.touched_vertices, vertex_elements_);
  settle_touched(change.touched_edges, edge_elements_);
  settle_touched(change.touched_triangles, triangle_elements_);
}

void Features::erase_element(const Mesh& mesh, Index o, FeatureChange& change) {
  for (Index v : mesh.vertices(o)) {
    vertex_elements_.erase(v, o);
    change.touched_vertices.push_back(v);
    if (!vertex_elements_[v].empty()) continue;
    change.removed_vertices.push_back(v);
    --live_vertices_;
  }
  for (Index e : element_edges_[o]) {
    edge_elements_.erase(e, o);
    change.touched_edges.push_back(e);
    if (!edge_elements_[e].empty()) continue;
    edge_table_.erase(e, edges_);
    free_edges_.push_back(e);
    change.removed_edges.push_back(e);
    --live_edges_;
  }
  for (Index f : element_triangles_[o]) {
    triangle_elements_.erase(f, o);
    change.touched_triangles.push_back(f);
    if (!triangle_elements_[f].empty()) continue;
    triangle_table_.erase(f, triangles_);
    free_triangles_.push_back(f);
    change.removed_triangles.push_back(f);
    --live_triangles_;
  }
  element_edges_.clear_list(o);
  element_triangles_.clear_list(o);
}

Index Features::live_edge(Index a, Index b, FeatureChange& change) {
  const std::array<Index, 2> key = ascending(a, b);
  const Index slot = free_slot(free_edges_, edges_.size());
  const Index e = edge_table_.find_or_insert(key, slot, edges_);
  if (e != slot) return e;
  if (free_edges_.empty()) {
    edges_.push_back(key);
    edge_elements_.extend(edges_.size());
  } else {
    free_edges_.pop_back();
    edges_[e] = key;
  }
  change.added_edges.push_back(e);
  ++live_edges_;
  return e;
}

Index Features::live_triangle(Index a, Index b, Index c, FeatureChange& change) {
  const std::array<Index, 3> key = ascending(a, b, c);
  const Index slot = free_slot(free_triangles_, triangles_.size());
  const Index f = triangle_table_.find_or_insert(key, slot, triangles_);
  if (f != slot) return f;
  if (free_triangles_.empty()) {
    triangles_.push_back(key);
    triangle_elements_.extend(triangles_.size());
  } else {
    free_triangles_.pop_back();
    triangles_[f] = key;
  }
  change.added_triangles.push_back(f);
  ++live_triangles_;
  return f;
}

void Features::insert_element(const Mesh& mesh, Index o, FeatureChange& change) {
  std::vector<Index> edges, triangles;
  for (Index v : mesh.vertices(o)) {
    if (vertex_elements_[v].empty()) {
      change.added_vertices.push_back(v);
      ++live_vertices_;
    }
    vertex_elements_.insert(v, o);
    change.touched_vertices.push_back(v);
  }
  visit_boundary(
      mesh, o, edge_set_,
      [&](Index a, Index b) {
        const Index e = live_edge(a, b, change);
        edge_elements_.insert(e, o);
        edges.push_back(e);
        change.touched_edges.push_back(e);
      },
      [&](Index a, Index b, Index c) {
        const Index f = live_triangle(a, b, c, change);
        triangle_elements_.insert(f, o);
        triangles.push_back(f);
        change.touched_triangles.push_back(f);
      });
  element_edges_.assign(o, edges);
  element_triangles_.assign(o, triangles);
}

Index Features::find_edge(Index v0, Index v1) const { return edge_table_.find(ascending(v0, v1), edges_); }

Index Features::find_triangle(Index v0, Index v1, Index v2) const {
  return triangle_table_.find(ascending(v0, v1, v2), triangles_);
}

std::size_t Features::bytes() const {
  return edges_.capacity() * sizeof(edges_[0]) + triangles_.capacity() * sizeof(triangles_[0]) + edge_table_.bytes() +
         triangle_table_.bytes() + vertex_elements_.bytes() + edge_elements_.bytes() + triangle_elements_.bytes() +
         element_edges_.bytes() + element_triangles_.bytes() +
         (free_edges_.capacity() + free_triangles_.capacity()) * sizeof(Index);
}

}  // namespace volccd
