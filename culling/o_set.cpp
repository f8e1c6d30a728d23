#include <volccd/culling/o_set.hpp>

#include <algorithm>
#include <span>
#include <utility>
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

/// All used vertices and all elements, in breadth-first order, so that neighbours follow each other closely. The same
/// elements are examined for nearby features, and the numbering may have scattered them over memory.
struct NearOrder {
  std::vector<Index> vertices, elements;

  NearOrder(const Mesh& mesh, const Features& features) {
    std::vector<char> vertex_seen(features.vertex_slots(), 0), element_seen(mesh.element_slots(), 0);
    vertices.reserve(features.vertex_count());
    elements.reserve(mesh.element_count());
    for (Index start = 0, next = 0; start < features.vertex_slots(); ++start) {
      if (vertex_seen[start] || features.vertex_elements(start).empty()) continue;
      vertex_seen[start] = 1;
      vertices.push_back(start);
      for (; next < vertices.size(); ++next)
        for (const Index o : features.vertex_elements(vertices[next])) {
          if (element_seen[o]) continue;
          element_seen[o] = 1;
          elements.push_back(o);
          for (const Index v : mesh.vertices(o)) {
            if (vertex_seen[v]) continue;
            vertex_seen[v] = 1;
            vertices.push_back(v);
          }
        }
    }
  }
};

}  // namespace

struct OSet::Impl {
  /// Scratch memory of one worker.
  struct Worker {
    detail::ElementTouch touch;
    std::vector<Index> covering;
  };
  /// Features whose incident elements changed; all of their pairs are recomputed.
  struct Renewed {
    std::vector<Index> vertices, triangles, edges;
  };

  explicit Impl(OSetKind set_kind) : kind(set_kind) {}

  void build(const Topology& topology, Executor& executor);
  void update(const Topology& topology, Executor& executor);
  Renewed renew(const Features& features);
  void find_pairs(const Topology& topology, const Renewed& renewed, Executor& executor);
  template <class WriteRow>
  void write_rows(const Topology& topology, Rows rows, std::span<const Index> items, Executor& executor,
                  WriteRow&& write_row);
  void write_vertex_rows(const Topology& topology, std::span<const Index> vertices, Executor& executor);

  bool literal() const { return kind == OSetKind::literal; }

  OSetKind kind;
  TopologyDelta delta;
  OSetBlocks blocks;
  std::vector<Worker> workers;
};

/// Calls write_row(item, partners, writer) for all items. Items are distributed to threads in parts that do not depend
/// on their number, and the parts are joined in order.
template <class WriteRow>
void OSet::Impl::write_rows(const Topology& topology, Rows rows, std::span<const Index> items, Executor& executor,
                            WriteRow&& write_row) {
  constexpr std::size_t kPartItems = 2048;
  workers.resize(executor.workers());
  std::vector<OSetBlocks::Part> parts((items.size() + kPartItems - 1) / kPartItems, blocks.new_part());
  executor.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end, unsigned w) {
    Worker& scratch = workers[w];
    scratch.touch.fit(topology.features().vertex_slots(), topology.mesh().element_slots());
    OSetPartners partners(topology, scratch.touch, scratch.covering);
    for (std::size_t p = begin; p < end; ++p) {
      OSetBlocks::Writer writer(parts[p], rows);
      const std::size_t first = p * kPartItems;
      for (const Index item : items.subspan(first, std::min(kPartItems, items.size() - first)))
        write_row(item, partners, writer);
      writer.flush();
    }
  });
  for (OSetBlocks::Part& part : parts) blocks.append(std::move(part));
}

void OSet::Impl::write_vertex_rows(const Topology& topology, std::span<const Index> vertices, Executor& executor) {
  write_rows(topology, Rows::vertex, vertices, executor,
             [&](Index v, OSetPartners& partners, OSetBlocks::Writer& rows) {
               rows.begin_row(v);
               partners.triangles_of_vertex(literal(), v, [&](Index f) { rows.add(f); });
               rows.end_row();
             });
}

void OSet::Impl::build(const Topology& topology, Executor& executor) {
  const Features& features = topology.features();
  for (Worker& worker : workers) worker = {};
  blocks.start_over(features);
  const NearOrder order(topology.mesh(), features);
  write_vertex_rows(topology, order.vertices, executor);
  write_rows(topology, Rows::edge, order.elements, executor,
             [&](Index o, OSetPartners& partners, OSetBlocks::Writer& rows) {
               for (const Index e : features.own_edges(o)) {
                 rows.begin_row(e);
                 partners.edges_of_edge(
                     literal(), e, [e](Index e2) { return e2 > e; }, [&](Index e2) { rows.add(e2); });
                 rows.end_row();
               }
             });
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
void OSet::Impl::find_pairs(const Topology& topology, const Renewed& renewed, Executor& executor) {
  write_vertex_rows(topology, renewed.vertices, executor);
  write_rows(topology, Rows::triangle, renewed.triangles, executor,
             [&](Index f, OSetPartners& partners, OSetBlocks::Writer& rows) {
               rows.begin_row(f);
               partners.vertices_of_triangle(
                   literal(), f, [&](Index v) { return !blocks.vertex_is_new(v); }, [&](Index v) { rows.add(v); });
               rows.end_row();
             });
  write_rows(
      topology, Rows::edge, renewed.edges, executor, [&](Index e, OSetPartners& partners, OSetBlocks::Writer& rows) {
        rows.begin_row(e);
        partners.edges_of_edge(
            literal(), e, [&](Index e2) { return e2 > e || !blocks.edge_is_new(e2); }, [&](Index e2) { rows.add(e2); });
        rows.end_row();
      });
}

void OSet::Impl::update(const Topology& topology, Executor& executor) {
  const TopologyDelta::Extent changed = delta.sync(topology);
  // A build takes less time per feature.
  const bool many = delta.changed_slots().size() > topology.mesh().element_count() / 4;
  if (changed == TopologyDelta::Extent::everything || many) {
    build(topology, executor);
  } else if (changed == TopologyDelta::Extent::edits) {
    blocks.next_epoch(topology.features());
    find_pairs(topology, renew(topology.features()), executor);
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

void OSet::build(const Topology& topology, Executor& executor) {
  impl_->delta.sync(topology);
  impl_->build(topology, executor);
  impl_->delta.confirm();
}

void OSet::update(const Topology& topology, Executor& executor) { impl_->update(topology, executor); }

void OSet::append(std::size_t block, TestBatch& out) const { impl_->blocks.append(block, out); }

OSetCounts OSet::counts() const {
  OSetCounts counts;
  impl_->blocks.count(counts.vf, counts.ee);
  return counts;
}

std::size_t OSet::bytes() const {
  std::size_t sum = impl_->delta.bytes() + impl_->blocks.bytes();
  for (const Impl::Worker& worker : impl_->workers)
    sum += worker.touch.bytes() + worker.covering.capacity() * sizeof(Index);
  return sum;
}

}  // namespace volccd
