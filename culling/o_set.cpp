#include <volccd/culling/o_set.hpp>

#include <algorithm>
#include <cassert>
#include <vector>

#include <volccd/culling/detail/o_set_blocks.hpp>
#include <volccd/culling/detail/o_set_difference.hpp>
#include <volccd/culling/detail/o_set_partners.hpp>

namespace volccd {

namespace {

using detail::OSetBlocks;
using detail::OSetDifference;
using detail::OSetPartners;
using Rows = OSetBlocks::Rows;

/// The features of each element of which it is the first incident one.
class OwnFeatures {
 public:
  template <class Incident>
  OwnFeatures(Index elements, Index features, Incident&& incident) : begins_(elements + 1, 0) {
    for (Index i = 0; i < features; ++i)
      if (const std::span<const Index> inc = incident(i); !inc.empty()) ++begins_[inc[0] + 1];
    for (Index o = 0; o < elements; ++o) begins_[o + 1] += begins_[o];
    values_.resize(begins_[elements]);
    std::vector<Index> ends(begins_.begin(), begins_.end() - 1);
    for (Index i = 0; i < features; ++i)
      if (const std::span<const Index> inc = incident(i); !inc.empty()) values_[ends[inc[0]]++] = i;
  }
  std::span<const Index> operator()(Index o) const {
    return {values_.data() + begins_[o], values_.data() + begins_[o + 1]};
  }

 private:
  std::vector<Index> begins_, values_;
};

/// Visits each vertex in use and each element once, neighbours soon after each other (breadth first): around features
/// that are near, the same elements are looked at, which numbering may have scattered over all of memory.
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

void sort_unique(std::vector<Index>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

struct OSet::Impl {
  /// What lies between the version seen and the present one, whatever the steps were.
  struct Change {
    std::vector<OSetDifference::Simplex> removed, added;
    std::vector<Index> added_slots;
    bool simplices = true;  ///< only those were removed and added; otherwise `removed` and `added` are not complete
  };
  /// Features all of whose pairs are to be found anew.
  struct Reborn {
    std::vector<Index> vertices, triangles, edges;
  };

  explicit Impl(OSetKind set_kind) : kind(set_kind) {}

  void build(const Topology& topology);
  void update(const Topology& topology, const std::vector<const TopologyChange*>& changes);
  void fit(const Topology& topology);
  Change take_over(const Mesh& mesh, const std::vector<const TopologyChange*>& changes);
  bool bear_anew(std::span<const Index> inc, bool all) const;
  Reborn bear(const Features& features, const std::vector<const TopologyChange*>& changes, bool all);
  void apply_difference(const Topology& topology, const Change& change);
  void find_anew(const Topology& topology, const Reborn& reborn);

  bool literal() const { return kind == OSetKind::literal; }

  OSetKind kind;
  std::uint64_t version = 0;
  OSetBlocks blocks;
  detail::ElementVertices vertices;
  // Scratch.
  detail::ElementTouch touch;
  std::vector<Index> covering;
  std::vector<Index> runs_of_vertex;  ///< all 0
  std::vector<std::uint8_t> added;    ///< by element; all 0
};

void OSet::Impl::fit(const Topology& topology) {
  const Features& features = topology.features();
  touch.fit(features.vertex_slots(), topology.mesh().element_slots(),
            std::max({features.vertex_slots(), features.triangle_slots(), features.edge_slots()}));
  runs_of_vertex.resize(features.vertex_slots(), 0);
  added.resize(topology.mesh().element_slots(), 0);
}

void OSet::Impl::build(const Topology& topology) {
  const Features& features = topology.features();
  const Mesh& mesh = topology.mesh();
  version = 0;  // stays so if memory runs out: then the next update starts over
  touch = {};
  runs_of_vertex.clear();
  added.clear();
  blocks.start_over(features);
  vertices.build(mesh);
  fit(topology);

  const OwnFeatures own_triangles(mesh.element_slots(), features.triangle_slots(),
                                  [&](Index f) { return features.triangle_elements(f); });
  const OwnFeatures own_edges(mesh.element_slots(), features.edge_slots(),
                              [&](Index e) { return features.edge_elements(e); });
  OSetPartners partners(features, vertices, touch, covering);
  OSetBlocks::Writer vertex_rows(blocks, Rows::vertex), edge_rows(blocks, Rows::edge);
  for_each_near(
      mesh, features,
      [&](Index v) {
        vertex_rows.begin_row(v);
        partners.triangles_of_vertex(literal(), v, own_triangles, [&](Index f) { vertex_rows.add(f); });
        vertex_rows.end_row();
      },
      [&](Index o) {
        for (Index e : own_edges(o)) {
          edge_rows.begin_row(e);
          partners.edges_of_edge(
              literal(), e, own_edges, [e](Index e2) { return e2 > e; }, [&](Index e2) { edge_rows.add(e2); });
          edge_rows.end_row();
        }
      });
  vertex_rows.flush();
  edge_rows.flush();
  blocks.settle();
  version = topology.version();
}

/// Brings `vertices` up to date, and says what has changed in it.
OSet::Impl::Change OSet::Impl::take_over(const Mesh& mesh, const std::vector<const TopologyChange*>& changes) {
  std::vector<Index> slots;
  for (const TopologyChange* change : changes) {
    slots.insert(slots.end(), change->removed_elements.begin(), change->removed_elements.end());
    slots.insert(slots.end(), change->added_elements.begin(), change->added_elements.end());
  }
  sort_unique(slots);
  Change change;
  const auto note = [&](Index o, std::vector<OSetDifference::Simplex>& list) {
    change.simplices &= vertices.simplex(o);
    if (vertices.simplex(o)) list.push_back({vertices[o][0], vertices[o][1], vertices[o][2], vertices[o][3]});
  };
  for (Index o : slots)
    if (vertices.holds(o)) note(o, change.removed);
  vertices.update(mesh, slots);
  for (Index o : slots)
    if (vertices.holds(o)) {
      note(o, change.added);
      change.added_slots.push_back(o);
    }
  return change;
}

/// Whether the pairs of a live feature are to be found anew: none of its elements stays, or all are to be.
bool OSet::Impl::bear_anew(std::span<const Index> inc, bool all) const {
  return all || std::all_of(inc.begin(), inc.end(), [&](Index o) { return added[o] != 0; });
}

OSet::Impl::Reborn OSet::Impl::bear(const Features& features, const std::vector<const TopologyChange*>& changes,
                                    bool all) {
  Reborn reborn;
  for (const TopologyChange* change : changes) {
    const FeatureChange& f = change->features;
    for (Index v : f.removed_vertices) blocks.bear_vertex(v);
    for (Index t : f.removed_triangles) blocks.bear_triangle(t);
    for (Index e : f.removed_edges) blocks.bear_edge(e);
    const auto collect = [&](const std::vector<Index>& touched, std::vector<Index>& list, auto&& incident) {
      for (Index i : touched)
        if (const std::span<const Index> inc = incident(i); !inc.empty() && bear_anew(inc, all)) list.push_back(i);
    };
    collect(f.touched_vertices, reborn.vertices, [&](Index v) { return features.vertex_elements(v); });
    collect(f.touched_triangles, reborn.triangles, [&](Index t) { return features.triangle_elements(t); });
    collect(f.touched_edges, reborn.edges, [&](Index e) { return features.edge_elements(e); });
  }
  for (auto* list : {&reborn.vertices, &reborn.triangles, &reborn.edges}) sort_unique(*list);
  for (Index v : reborn.vertices) blocks.bear_vertex(v);
  for (Index t : reborn.triangles) blocks.bear_triangle(t);
  for (Index e : reborn.edges) blocks.bear_edge(e);
  return reborn;
}

/// Pairs of features that live on. First what the added elements end: a pair may have come with the removal only.
void OSet::Impl::apply_difference(const Topology& topology, const Change& change) {
  OSetDifference difference(topology.features(), vertices, touch,
                            change.added.empty() ? std::span<const std::uint8_t>() : added, runs_of_vertex);
  TestBatch ended, come;
  difference.run(change.added, ended);
  for (const FeaturePair p : ended.vf) blocks.erase_vf(p.a, p.b);
  for (const FeaturePair p : ended.ee) blocks.erase_ee(p.a, p.b);

  difference.run(change.removed, come);
  OSetBlocks::Writer vertex_rows(blocks, Rows::vertex), edge_rows(blocks, Rows::edge);
  const auto write = [](OSetBlocks::Writer& rows, FeaturePair p) {
    rows.begin_row(p.a);
    rows.add(p.b);
    rows.end_row();
  };
  for (const FeaturePair p : come.vf)
    if (!blocks.erased_vf_now(p.a, p.b)) write(vertex_rows, p);
  for (const FeaturePair p : come.ee)
    if (!blocks.erased_ee_now(p.a, p.b)) write(edge_rows, p);
  vertex_rows.flush();
  edge_rows.flush();
}

/// All pairs of the features born in this epoch. A pair of two is written once: VF by its vertex, EE by its smaller
/// edge.
void OSet::Impl::find_anew(const Topology& topology, const Reborn& reborn) {
  OSetPartners partners(topology.features(), vertices, touch, covering);
  OSetBlocks::Writer vertex_rows(blocks, Rows::vertex), triangle_rows(blocks, Rows::triangle),
      edge_rows(blocks, Rows::edge);
  for (Index v : reborn.vertices) {
    vertex_rows.begin_row(v);
    partners.triangles_of_vertex(literal(), v, OSetPartners::EveryTriangle{}, [&](Index f) { vertex_rows.add(f); });
    vertex_rows.end_row();
  }
  for (Index f : reborn.triangles) {
    triangle_rows.begin_row(f);
    partners.vertices_of_triangle(
        topology.mesh(), literal(), f, [&](Index v) { return !blocks.born_vertex(v); },
        [&](Index v) { triangle_rows.add(v); });
    triangle_rows.end_row();
  }
  for (Index e : reborn.edges) {
    edge_rows.begin_row(e);
    partners.edges_of_edge(
        literal(), e, OSetPartners::EveryEdge{}, [&](Index e2) { return e2 > e || !blocks.born_edge(e2); },
        [&](Index e2) { edge_rows.add(e2); });
    edge_rows.end_row();
  }
  vertex_rows.flush();
  triangle_rows.flush();
  edge_rows.flush();
}

void OSet::Impl::update(const Topology& topology, const std::vector<const TopologyChange*>& changes) {
  version = 0;  // as in build()
  const Change change = take_over(topology.mesh(), changes);
  // A build takes less for a feature.
  const std::size_t changed = change.removed.size() + change.added.size();
  if (changed > topology.mesh().element_count() / 4) return build(topology);

  blocks.next_epoch(topology.features());
  fit(topology);
  const bool all = literal() || !change.simplices;
  for (Index o : change.added_slots) added[o] = 1;
  const Reborn reborn = bear(topology.features(), changes, all);
  if (!all) apply_difference(topology, change);
  for (Index o : change.added_slots) added[o] = 0;
  find_anew(topology, reborn);
  blocks.compact_if_stale(topology.features());
  version = topology.version();
}

OSet::OSet(OSetKind kind) : impl_(std::make_unique<Impl>(kind)) { assert(kind != OSetKind::none); }
OSet::OSet(OSet&&) noexcept = default;
OSet& OSet::operator=(OSet&&) noexcept = default;
OSet::~OSet() = default;

OSetKind OSet::kind() const { return impl_->kind; }
std::uint64_t OSet::version() const { return impl_->version; }
std::size_t OSet::blocks() const { return impl_->blocks.size(); }

void OSet::build(const Topology& topology) { impl_->build(topology); }

void OSet::update(const Topology& topology) {
  std::vector<const TopologyChange*> changes;
  if (impl_->version == 0 || !topology.changes_since(impl_->version, changes)) return impl_->build(topology);
  if (!changes.empty()) impl_->update(topology, changes);
}

void OSet::append(std::size_t block, TestBatch& out) const { impl_->blocks.append(block, out); }

OSetCounts OSet::counts() const {
  OSetCounts counts;
  impl_->blocks.count(counts.vf, counts.ee);
  return counts;
}

std::size_t OSet::bytes() const {
  return impl_->blocks.bytes() + impl_->vertices.bytes() + impl_->touch.bytes() +
         (impl_->covering.capacity() + impl_->runs_of_vertex.capacity()) * sizeof(Index) + impl_->added.capacity();
}

}  // namespace volccd
