#include <volccd/mesh/features.hpp>

#include <algorithm>

#include <volccd/mesh/detail/incidences.hpp>
#include <volccd/mesh/detail/number_tuples.hpp>

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

/// Appends to a list that ascends and has no duplicates, and keeps it so.
class Merged {
 public:
  explicit Merged(std::vector<Index>& list) : list_(list), old_(list.size()) {}
  ~Merged() {
    if (old_ == 0) return;
    std::inplace_merge(list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(old_), list_.end());
    list_.erase(std::unique(list_.begin(), list_.end()), list_.end());
  }
  Merged(const Merged&) = delete;
  Merged& operator=(const Merged&) = delete;
  /// Ascending.
  void push_back(Index i) { list_.push_back(i); }

 private:
  std::vector<Index>& list_;
  std::size_t old_;
};

/// Takes the incidences out, and reports what died to `died` too.
template <class Died>
void take_out(detail::Incidences& incidences, detail::IncidencePool& lists, std::vector<Index>& touched,
              std::vector<Index>& removed, Died&& died) {
  {
    Merged touched_now(touched), removed_now(removed);
    incidences.group([&](Index i, std::span<const Index> elements) {
      lists.erase(i, elements);
      if (!lists[i].empty()) {
        touched_now.push_back(i);
        return;
      }
      removed_now.push_back(i);
      died(i);
    });
  }
  std::erase_if(touched, [&](Index i) { return lists[i].empty(); });
}

void put_in(detail::Incidences& incidences, detail::IncidencePool& lists, std::vector<Index>& touched) {
  Merged touched_now(touched);
  incidences.group([&](Index i, std::span<const Index> elements) {
    lists.insert(i, elements);
    touched_now.push_back(i);
  });
}

/// Slot of the feature with these vertices; a new one if there is none, reported in `added`.
template <std::size_t N>
Index live_slot(const std::array<Index, N>& key, std::vector<std::array<Index, N>>& tuples,
                detail::TupleTable<N>& table, std::vector<Index>& free, std::vector<Index>& added) {
  const Index fresh = free.empty() ? static_cast<Index>(tuples.size()) : free.back();
  const Index slot = table.find_or_insert(key, fresh, tuples);
  if (slot != fresh) return slot;
  if (free.empty()) {
    tuples.push_back(key);
  } else {
    free.pop_back();
    tuples[slot] = key;
  }
  added.push_back(slot);
  return slot;
}

std::vector<Index> sorted(std::span<const Index> values) {
  std::vector<Index> result(values.begin(), values.end());
  std::sort(result.begin(), result.end());
  return result;
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

/// Tables of the edges or the triangles from their occurrences.
template <std::size_t N>
void build_kind(const detail::Occurrences<N>& occurrences, const Mesh& mesh, std::vector<std::array<Index, N>>& tuples,
                detail::TupleTable<N>& table, detail::IncidencePool& incidence, detail::IncidencePool& of_element) {
  of_element.clear(mesh.element_slots(), occurrences.tuples.size());
  std::vector<Index> numbers;
  detail::number_tuples(occurrences, mesh.vertex_count(), tuples, incidence, numbers);
  for (std::size_t k = 0; k < numbers.size(); ++k) of_element.push_back(occurrences.elements[k], numbers[k]);
  table.fill(tuples);
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
    if (!mesh.alive(o)) continue;
    for (Index v : mesh.vertices(o)) ++vertex_lengths[v];
    visit_boundary(
        mesh, o, edge_set_, [&](Index a, Index b) { edges.add(ascending(a, b), o); },
        [&](Index a, Index b, Index c) { triangles.add(ascending(a, b, c), o); });
  }

  live_vertices_ =
      mesh.vertex_count() - static_cast<Index>(std::count(vertex_lengths.begin(), vertex_lengths.end(), Index{0}));
  vertex_elements_.layout(vertex_lengths);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    for (Index v : mesh.vertices(o)) vertex_elements_.append(v, o);

  build_kind(edges, mesh, edges_, edge_table_, edge_elements_, element_edges_);
  edges = {};  // both at once would be the peak of memory
  build_kind(triangles, mesh, triangles_, triangle_table_, triangle_elements_, element_triangles_);
}

void Features::remove(const Mesh& mesh, std::span<const Index> elements, FeatureChange& change) {
  const std::vector<Index> ascending_elements = sorted(elements);
  detail::Incidences gone;
  for (Index o : ascending_elements)
    for (Index v : mesh.vertices(o)) gone.add(v, o);
  take_out(gone, vertex_elements_, change.touched_vertices, change.removed_vertices, [&](Index) { --live_vertices_; });

  gone.clear();
  for (Index o : ascending_elements) {
    for (Index e : element_edges_[o]) gone.add(e, o);
    element_edges_.assign(o, {});
  }
  take_out(gone, edge_elements_, change.touched_edges, change.removed_edges, [&](Index e) {
    edge_table_.erase(e, edges_);
    free_edges_.push_back(e);
  });

  gone.clear();
  for (Index o : ascending_elements) {
    for (Index f : element_triangles_[o]) gone.add(f, o);
    element_triangles_.assign(o, {});
  }
  take_out(gone, triangle_elements_, change.touched_triangles, change.removed_triangles, [&](Index f) {
    triangle_table_.erase(f, triangles_);
    free_triangles_.push_back(f);
  });
}

void Features::add(const Mesh& mesh, std::span<const Index> elements, FeatureChange& change) {
  vertex_elements_.extend(mesh.vertex_count());
  element_edges_.extend(mesh.element_slots());
  element_triangles_.extend(mesh.element_slots());
  const std::vector<Index> ascending_elements = sorted(elements);
  detail::Incidences vertices, edges, triangles;
  std::vector<Index> edges_of, triangles_of;  // of one element
  const std::size_t added_before = change.added_vertices.size();
  for (Index o : ascending_elements) {
    for (Index v : mesh.vertices(o)) {
      if (vertex_elements_[v].empty()) change.added_vertices.push_back(v);
      vertices.add(v, o);
    }
    edges_of.clear();
    triangles_of.clear();
    const auto edge = [&](Index a, Index b) {
      edges_of.push_back(live_slot(ascending(a, b), edges_, edge_table_, free_edges_, change.added_edges));
    };
    const auto triangle = [&](Index a, Index b, Index c) {
      triangles_of.push_back(
          live_slot(ascending(a, b, c), triangles_, triangle_table_, free_triangles_, change.added_triangles));
    };
    visit_boundary(mesh, o, edge_set_, edge, triangle);
    for (Index e : edges_of) edges.add(e, o);
    for (Index f : triangles_of) triangles.add(f, o);
    element_edges_.assign(o, edges_of);
    element_triangles_.assign(o, triangles_of);
  }
  detail::sort_unique(change.added_vertices);
  live_vertices_ += static_cast<Index>(change.added_vertices.size() - added_before);
  detail::sort_unique(change.added_edges);
  detail::sort_unique(change.added_triangles);
  edge_elements_.extend(edges_.size());
  triangle_elements_.extend(triangles_.size());
  put_in(vertices, vertex_elements_, change.touched_vertices);
  put_in(edges, edge_elements_, change.touched_edges);
  put_in(triangles, triangle_elements_, change.touched_triangles);
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
