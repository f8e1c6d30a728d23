#include <volccd/culling/o_set.hpp>

#include <vector>

#include <volccd/core/sort_unique.hpp>
#include <volccd/culling/detail/o_set_blocks.hpp>
#include <volccd/culling/detail/o_set_partners.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

namespace {

using detail::OSetBlocks;
using detail::OSetPartners;
using Rows = OSetBlocks::Rows;

/// Visits each used vertex and each element once, in breadth-first order, so that neighbours follow each other closely.
/// The same elements are examined for nearby features, and the numbering may have scattered them over memory.
template <class VisitVertex, class VisitElement>
void for_each_near(const Mesh& mesh, const Features& features, VisitVertex&& visit_vertex,
                   VisitElement&& visit_element) {
  std::vector<char> vertex_seen(features.vertex_slots(), 0), element_seen(mesh.element_slots(), 0);
  std::vector<Index> queue;
  queue.reserve(features.vertex_count());
  for (Index start = 0, next = 0; start < features.vertex_slots(); ++start) {
    if (vertex_seen[start] || features.vertex_elements(start).empty()) continue;
    vertex_seen[start] = 1;
    queue.push_back(start);
    for (; next < queue.size(); ++next) {
      visit_vertex(queue[next]);
      for (Index o : features.vertex_elements(queue[next])) {
        if (element_seen[o]) continue;
        element_seen[o] = 1;
        visit_element(o);
        for (Index v : mesh.vertices(o)) {
          if (vertex_seen[v]) continue;
          vertex_seen[v] = 1;
          queue.push_back(v);
        }
      }
    }
  }
}

}  // namespace

struct OSet::Impl {
  /// Features whose incident elements changed; all of their pairs are recomputed.
  struct Renewed {
    std::vector<Index> vertices, triangles, edges;
  };

  explicit Impl(OSetKind set_kind) : kind(set_kind) {}

  void build(const Topology& topology);
  void update(const Topology& topology);
  Renewed renew(const Features& features);
  void find_pairs(const Topology& topology, const Renewed& renewed);

  bool literal() const { return kind == OSetKind::literal; }

  OSetKind kind;
  TopologyDelta delta;
  OSetBlocks blocks;
  // Scratch.
  detail::ElementTouch touch;
  std::vector<Index> covering;
};

void OSet::Impl::build(const Topology& topology) {
  const Features& features = topology.features();
  touch = {};
  blocks.start_over(features);
  touch.fit(features.vertex_slots(), topology.mesh().element_slots());
  OSetPartners partners(topology, touch, covering);
  OSetBlocks::Writer vertex_rows(blocks, Rows::vertex), edge_rows(blocks, Rows::edge);
  for_each_near(
      topology.mesh(), features,
      [&](Index v) {
        vertex_rows.begin_row(v);
        partners.triangles_of_vertex(literal(), v, [&](Index f) { vertex_rows.add(f); });
        vertex_rows.end_row();
      },
      [&](Index o) {
        for (Index e : features.own_edges(o)) {
          edge_rows.begin_row(e);
          partners.edges_of_edge(
              literal(), e, [e](Index e2) { return e2 > e; }, [&](Index e2) { edge_rows.add(e2); });
          edge_rows.end_row();
        }
      });
  vertex_rows.flush();
  edge_rows.flush();
  blocks.settle();
}

OSet::Impl::Renewed OSet::Impl::renew(const Features& features) {
  Renewed renewed;
  for (const TopologyChange* change : delta.changes()) {
    const FeatureChange& f = change->features;
    for (Index v : f.removed_vertices) blocks.renew_vertex(v);
    for (Index t : f.removed_triangles) blocks.renew_triangle(t);
    for (Index e : f.removed_edges) blocks.renew_edge(e);
    const auto collect = [](const std::vector<Index>& touched, std::vector<Index>& list, auto&& incident) {
      for (Index i : touched)
        if (!incident(i).empty()) list.push_back(i);
    };
    collect(f.touched_vertices, renewed.vertices, [&](Index v) { return features.vertex_elements(v); });
    collect(f.touched_triangles, renewed.triangles, [&](Index t) { return features.triangle_elements(t); });
    collect(f.touched_edges, renewed.edges, [&](Index e) { return features.edge_elements(e); });
  }
  for (auto* list : {&renewed.vertices, &renewed.triangles, &renewed.edges}) sort_unique(*list);
  for (Index v : renewed.vertices) blocks.renew_vertex(v);
  for (Index t : renewed.triangles) blocks.renew_triangle(t);
  for (Index e : renewed.edges) blocks.renew_edge(e);
  return renewed;
}

/// Writes all pairs of the renewed features. A pair of two renewed features is written once: VF for its vertex, EE for
/// its smaller edge.
void OSet::Impl::find_pairs(const Topology& topology, const Renewed& renewed) {
  OSetPartners partners(topology, touch, covering);
  OSetBlocks::Writer vertex_rows(blocks, Rows::vertex), triangle_rows(blocks, Rows::triangle),
      edge_rows(blocks, Rows::edge);
  for (Index v : renewed.vertices) {
    vertex_rows.begin_row(v);
    partners.triangles_of_vertex(literal(), v, [&](Index f) { vertex_rows.add(f); });
    vertex_rows.end_row();
  }
  for (Index f : renewed.triangles) {
    triangle_rows.begin_row(f);
    partners.vertices_of_triangle(
        literal(), f, [&](Index v) { return !blocks.vertex_is_new(v); }, [&](Index v) { triangle_rows.add(v); });
    triangle_rows.end_row();
  }
  for (Index e : renewed.edges) {
    edge_rows.begin_row(e);
    partners.edges_of_edge(
        literal(), e, [&](Index e2) { return e2 > e || !blocks.edge_is_new(e2); },
        [&](Index e2) { edge_rows.add(e2); });
    edge_rows.end_row();
  }
  vertex_rows.flush();
  triangle_rows.flush();
  edge_rows.flush();
}

void OSet::Impl::update(const Topology& topology) {
  const TopologyDelta::Extent changed = delta.sync(topology);
  // A build takes less time per feature.
  const bool many = delta.changed_slots().size() > topology.mesh().element_count() / 4;
  if (changed == TopologyDelta::Extent::everything || many) {
    build(topology);
  } else if (changed == TopologyDelta::Extent::edits) {
    blocks.next_epoch(topology.features());
    touch.fit(topology.features().vertex_slots(), topology.mesh().element_slots());
    find_pairs(topology, renew(topology.features()));
    blocks.compact_if_stale(topology.features());
  }
  delta.confirm();
}

OSet::OSet(OSetKind kind) : impl_(std::make_unique<Impl>(kind)) {}
OSet::OSet(OSet&&) noexcept = default;
OSet& OSet::operator=(OSet&&) noexcept = default;
OSet::~OSet() = default;

OSetKind OSet::kind() const { return impl_->kind; }
std::size_t OSet::blocks() const { return impl_->blocks.size(); }

void OSet::build(const Topology& topology) {
  impl_->delta.sync(topology);
  impl_->build(topology);
  impl_->delta.confirm();
}

void OSet::update(const Topology& topology) { impl_->update(topology); }

void OSet::append(std::size_t block, TestBatch& out) const { impl_->blocks.append(block, out); }

OSetCounts OSet::counts() const {
  OSetCounts counts;
  impl_->blocks.count(counts.vf, counts.ee);
  return counts;
}

std::size_t OSet::bytes() const {
  return impl_->delta.bytes() + impl_->blocks.bytes() + impl_->touch.bytes() +
         impl_->covering.capacity() * sizeof(Index);
}

}  // namespace volccd
