#include <volccd/culling/o_set/o_set.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/culling/o_set/detail/o_set_blocks.hpp>
#include <volccd/culling/o_set/detail/o_set_partners.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

namespace {

using detail::elements_at;
using detail::OSetBlocks;
using detail::OSetPartners;
using Owner = OSetBlocks::Owner;

/// Features of which pairs are to be computed.
struct FeatureLists {
  std::vector<Index> vertices, triangles, edges;
};

/// Orders a few features so that those with the same incident elements follow each other, ascending. If others have the
/// same first and last one, they may come in between, which costs only time.
template <Owner kind>
void group_by_elements(const Features& features, std::span<Index> few,
                       std::vector<std::pair<std::uint64_t, Index>>& scratch) {
  scratch.clear();
  for (const Index i : few) {
    const std::span<const Index> inc = elements_at<kind>(features, i);
    scratch.emplace_back(std::uint64_t{inc.front()} << 32 | inc.back(), i);
  }
  std::ranges::sort(scratch);
  std::ranges::transform(scratch, few.begin(), &std::pair<std::uint64_t, Index>::second);
}

/// All used vertices and all edges, in breadth-first order, so that neighbours follow each other closely. The same
/// elements are examined for nearby features, and the numbering may have scattered them over memory.
FeatureLists in_near_order(const Mesh& mesh, const Features& features) {
  FeatureLists lists;
  std::vector<char> vertex_seen(features.vertex_slots(), 0), element_seen(mesh.element_slots(), 0);
  std::vector<std::pair<std::uint64_t, Index>> scratch;
  lists.vertices.reserve(features.vertex_count());
  lists.edges.reserve(features.edge_count());
  const auto add_vertex = [&](Index v) {
    if (!std::exchange(vertex_seen[v], 1)) lists.vertices.push_back(v);
  };
  for (Index start = 0, next = 0; start < features.vertex_slots(); ++start) {
    if (!features.vertex_elements(start).empty()) add_vertex(start);
    for (; next < lists.vertices.size(); ++next)
      for (const Index o : features.vertex_elements(lists.vertices[next])) {
        if (std::exchange(element_seen[o], 1)) continue;
        const std::span<const Index> edges = features.own_edges(o);
        const std::size_t first_edge = lists.edges.size(), first_vertex = lists.vertices.size();
        lists.edges.insert(lists.edges.end(), edges.begin(), edges.end());
        for (const Index v : mesh.vertices(o)) add_vertex(v);
        group_by_elements<Owner::edge>(features, std::span(lists.edges).subspan(first_edge), scratch);
        group_by_elements<Owner::vertex>(features, std::span(lists.vertices).subspan(first_vertex), scratch);
      }
  }
  return lists;
}

/// How many features at the beginning of the list have the same incident elements.
template <Owner kind>
std::size_t alike(const Features& features, std::span<const Index> list) {
  const std::span<const Index> inc = elements_at<kind>(features, list.front());
  const auto end =
      std::ranges::find_if(list, [&](Index i) { return !std::ranges::equal(elements_at<kind>(features, i), inc); });
  return static_cast<std::size_t>(end - list.begin());
}

}  // namespace

struct OSet::Impl {
  explicit Impl(OSetKind set_kind) : kind(set_kind) {}

  void build(const Topology& topology, Executor& executor);
  void update(const Topology& topology, Executor& executor, bool without_shell_neighbours);
  FeatureLists renew(const Features& features);
  void find_pairs(const Topology& topology, const FeatureLists& lists, Executor& executor);
  template <Owner owner, class Wanted>
  void write_rows(const Topology& topology, std::span<const Index> items, Executor& executor, Wanted&& wanted);

  OSetKind kind;
  bool leave_out_shell_neighbours = false;
  TopologyDelta delta;
  OSetBlocks blocks;
  std::vector<detail::ElementTouch> scratch;  ///< by worker
};

/// Writes the rows of these features: all partners of an item for which wanted(item, partner) is true. Items are
/// distributed to threads in parts that do not depend on their number, and the parts are joined in order.
template <Owner owner, class Wanted>
void OSet::Impl::write_rows(const Topology& topology, std::span<const Index> items, Executor& executor,
                            Wanted&& wanted) {
  constexpr std::size_t kPartItems = 2048;
  scratch.resize(executor.workers());
  std::vector<OSetBlocks::Part> parts((items.size() + kPartItems - 1) / kPartItems);
  executor.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end, unsigned w) {
    scratch[w].fit(topology.features().vertex_slots(), topology.mesh().element_slots());
    OSetPartners partners(topology, kind, leave_out_shell_neighbours, scratch[w]);
    for (std::size_t p = begin; p < end; ++p) {
      OSetBlocks::Writer rows(parts[p], owner);
      const std::size_t first = p * kPartItems;
      std::span<const Index> left = items.subspan(first, std::min(kPartItems, items.size() - first));
      while (!left.empty()) {
        const std::size_t n = alike<owner>(topology.features(), left);
        partners.find<owner>(
            left.first(n), wanted, [&](Index item) { rows.begin_row(item); },
            [&](Index partner) { rows.add(partner); });
        left = left.subspan(n);
      }
      rows.flush();
    }
  });
  for (OSetBlocks::Part& part : parts) blocks.append(std::move(part));
}

void OSet::Impl::build(const Topology& topology, Executor& executor) {
  for (detail::ElementTouch& touch : scratch) touch = {};
  blocks.start_over(topology.features());
  find_pairs(topology, in_near_order(topology.mesh(), topology.features()), executor);
  blocks.settle();
}

/// Invalidates the pairs of features whose incident elements changed, and returns those that have elements.
FeatureLists OSet::Impl::renew(const Features& features) {
  FeatureLists renewed;
  const auto collect = [&](Owner owner, const std::vector<Index>& removed, const std::vector<Index>& touched,
                           std::vector<Index>& list, auto&& incident) {
    for (const Index i : removed) blocks.renew(owner, i);
    for (const Index i : touched) {
      if (incident(i).empty()) continue;
      blocks.renew(owner, i);
      list.push_back(i);
    }
  };
  for (const TopologyChange* change : delta.changes()) {
    const FeatureChange& f = change->features;
    collect(Owner::vertex, f.removed_vertices, f.touched_vertices, renewed.vertices,
            [&](Index v) { return features.vertex_elements(v); });
    collect(Owner::triangle, f.removed_triangles, f.touched_triangles, renewed.triangles,
            [&](Index t) { return features.triangle_elements(t); });
    collect(Owner::edge, f.removed_edges, f.touched_edges, renewed.edges,
            [&](Index e) { return features.edge_elements(e); });
  }
  for (auto* list : {&renewed.vertices, &renewed.triangles, &renewed.edges}) sort_unique(*list);
  return renewed;
}

/// Writes all pairs of the listed features, which are new. A pair of two of them is written once: VF for its vertex, EE
/// for its smaller edge.
void OSet::Impl::find_pairs(const Topology& topology, const FeatureLists& lists, Executor& executor) {
  write_rows<Owner::vertex>(topology, lists.vertices, executor, [](Index, Index) { return true; });
  write_rows<Owner::triangle>(topology, lists.triangles, executor,
                              [&](Index, Index v) { return !blocks.is_new(Owner::vertex, v); });
  const bool all_new = blocks.all_new();
  write_rows<Owner::edge>(topology, lists.edges, executor, [&, all_new](Index e, Index e2) {
    return e2 > e || (!all_new && !blocks.is_new(Owner::edge, e2));
  });
}

void OSet::Impl::update(const Topology& topology, Executor& executor, bool without_shell_neighbours) {
  const bool other = std::exchange(leave_out_shell_neighbours, without_shell_neighbours) != without_shell_neighbours;
  const TopologyDelta::Extent changed = delta.sync(topology);
  // A build takes less time per feature.
  const bool many = delta.changed_slots().size() > topology.mesh().element_count() / 4;
  if (changed == TopologyDelta::Extent::everything || many || other) {
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
  impl_->leave_out_shell_neighbours = false;
  impl_->delta.sync(topology);
  impl_->build(topology, executor);
  impl_->delta.confirm();
}

void OSet::update(const Topology& topology, Executor& executor, bool leave_out_shell_neighbours) {
  impl_->update(topology, executor, leave_out_shell_neighbours);
}

void OSet::append(std::size_t block, TestBatch& out) const { impl_->blocks.append(block, out); }

OSetCounts OSet::counts() const { return impl_->blocks.counts(); }

std::size_t OSet::bytes() const { return heap_bytes(impl_->delta, impl_->blocks, impl_->scratch); }

}  // namespace volccd
