#include <volccd/culling/flood/detail/simplex_complex.hpp>

#include <algorithm>
#include <array>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

namespace {

using Triangle = std::array<Index, 3>;

bool is_simplex(ElementType type) { return type == ElementType::tetrahedron || type == ElementType::triangle; }

bool has(const Triangle& triangle, Index v) { return triangle[0] == v || triangle[1] == v || triangle[2] == v; }

/// Triangles of a polytope that are not a face of the fan from `apex`: those that contain the apex and whose opposite
/// edge is in no triangle without the apex.
std::vector<Triangle> left_over(const std::vector<Triangle>& boundary, Index apex) {
  std::vector<Triangle> rest;
  for (const Triangle& t : boundary) {
    if (!has(t, apex)) continue;
    const bool covered = std::any_of(boundary.begin(), boundary.end(), [&](const Triangle& other) {
      return !has(other, apex) && std::all_of(t.begin(), t.end(), [&](Index v) { return v == apex || has(other, v); });
    });
    if (!covered) rest.push_back(t);
  }
  return rest;
}

}  // namespace

void SimplexComplex::append_fan(const Mesh& mesh, Index element, std::vector<ElementSpec>& out) {
  const std::span<const Index> vertices = mesh.vertices(element);
  const std::size_t before = out.size();
  const auto add = [&](ElementType type, std::vector<Index> v) {
    out.push_back({type, std::move(v), {}, mesh.object(element), next_id_++});
  };
  const std::int64_t first_id = next_id_;
  if (is_simplex(mesh.type(element))) {
    add(mesh.type(element), {vertices.begin(), vertices.end()});
  } else {
    const std::vector<Triangle> boundary = oriented_boundary(mesh, element);
    const Index apex = *std::min_element(vertices.begin(), vertices.end());
    const bool shell = is_shell(mesh.type(element));
    for (const Triangle& t : boundary) {
      if (shell) add(ElementType::triangle, {t[0], t[1], t[2]});
      if (!shell && !has(t, apex)) add(ElementType::tetrahedron, {apex, t[0], t[1], t[2]});
    }
    if (mesh.type(element) == ElementType::polytope)
      for (const Triangle& t : left_over(boundary, apex)) add(ElementType::triangle, {t[0], t[1], t[2]});
  }
  fans_[element] = {first_id, static_cast<int>(out.size() - before)};
}

void SimplexComplex::build(const Topology& topology, Executor& executor) {
  const Mesh& mesh = topology.mesh();
  bool simplices = true;
  for (Index o = 0; o < mesh.element_slots() && simplices; ++o)
    simplices = !mesh.is_live(o) || is_simplex(mesh.type(o));
  own_.reset();
  fans_.clear();
  if (simplices) return;
  fans_.resize(mesh.element_slots());
  std::vector<ElementSpec> specs;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) append_fan(mesh, o, specs);
  Mesh complex;
  complex.add_vertices(mesh.vertex_ids());
  for (const ElementSpec& spec : specs) complex.add_element(spec);
  own_ = std::make_unique<Topology>(std::move(complex), executor);
  const Features& features = own_->features();
  edges_.assign(features.edge_slots(), kNone);
  triangles_.assign(features.triangle_slots(), kNone);
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty())
      edges_[e] = topology.features().find_edge(features.edge(e)[0], features.edge(e)[1]);
  for (Index f = 0; f < features.triangle_slots(); ++f)
    if (const auto& t = features.triangle(f); !features.triangle_elements(f).empty())
      triangles_[f] = topology.features().find_triangle(t[0], t[1], t[2]);
}

void SimplexComplex::edit(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  TopologyEdit edit;
  fans_.resize(mesh.element_slots());
  for (const Index o : delta_.changed_slots()) {
    for (int i = 0; i < fans_[o].count; ++i) edit.removed.push_back(own_->mesh().find_element(fans_[o].first_id + i));
    fans_[o] = {};
    if (mesh.is_live(o)) append_fan(mesh, o, edit.added);
  }
  const std::span<const std::int64_t> ids = mesh.vertex_ids();
  edit.new_vertex_ids.assign(ids.begin() + own_->mesh().vertex_count(), ids.end());
  if (edit.empty()) return;
  const FeatureChange& change = own_->apply(edit).features;
  const Features& features = own_->features();
  edges_.resize(features.edge_slots(), kNone);
  triangles_.resize(features.triangle_slots(), kNone);
  for (const auto* list : {&change.added_edges, &change.touched_edges})
    for (const Index e : *list) edges_[e] = topology.features().find_edge(features.edge(e)[0], features.edge(e)[1]);
  for (const auto* list : {&change.added_triangles, &change.touched_triangles})
    for (const Index f : *list) {
      const auto& t = features.triangle(f);
      triangles_[f] = topology.features().find_triangle(t[0], t[1], t[2]);
    }
}

void SimplexComplex::update(const Topology& topology, Executor& executor) {
  const TopologyDelta::Extent changed = delta_.sync(topology);
  mesh_ = &topology;
  bool anew = changed == TopologyDelta::Extent::everything;
  if (changed == TopologyDelta::Extent::edits && !own_)
    for (const Index o : delta_.changed_slots())
      anew = anew || (topology.mesh().is_live(o) && !is_simplex(topology.mesh().type(o)));
  if (anew)
    build(topology, executor);
  else if (changed == TopologyDelta::Extent::edits && own_)
    edit(topology);
  delta_.confirm();
}

void SimplexComplex::to_mesh_features(TestBatch& tests, std::size_t vf_begin, std::size_t ee_begin) const {
  if (!own_) return;
  const auto map = [](std::vector<FeaturePair>& list, std::size_t begin, auto&& mapped) {
    std::size_t kept = begin;
    for (std::size_t i = begin; i < list.size(); ++i) {
      const FeaturePair pair = mapped(list[i]);
      if (pair.a != kNone && pair.b != kNone) list[kept++] = pair;
    }
    list.resize(kept);
  };
  map(tests.vf, vf_begin, [&](FeaturePair p) { return FeaturePair{p.a, triangles_[p.b]}; });
  map(tests.ee, ee_begin, [&](FeaturePair p) {
    const Index a = edges_[p.a], b = edges_[p.b];
    return FeaturePair{std::min(a, b), std::max(a, b)};
  });
}

std::size_t SimplexComplex::bytes() const {
  return (own_ ? own_->bytes() : 0) + heap_bytes(delta_, fans_, edges_, triangles_);
}

}  // namespace volccd::detail
