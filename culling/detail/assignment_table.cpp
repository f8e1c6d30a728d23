#include <volccd/culling/detail/assignment_table.hpp>

#include <algorithm>

namespace volccd::detail {

namespace {

/// Room for n entries; grows so that it may be called at every change.
void reserve(std::vector<Index>& entries, std::size_t n) {
  if (n > entries.capacity()) entries.reserve(std::max(n, 2 * entries.size()));
}

}  // namespace

void AssignmentTable::update(const Topology& topology) {
  const Features& features = topology.features();
  reserve(vertex_, features.vertex_slots());
  reserve(edge_, features.edge_slots());
  reserve(triangle_, features.triangle_slots());
  const TopologyWatch::News news = watch_.look(topology);
  if (news == TopologyWatch::News::none) return;
  // From here on nothing needs memory.
  const auto first = [](std::span<const Index> elements) { return elements.empty() ? kNone : elements.front(); };
  vertex_.resize(features.vertex_slots());
  edge_.resize(features.edge_slots());
  triangle_.resize(features.triangle_slots());
  if (news == TopologyWatch::News::edited) {
    for (const TopologyChange* change : watch_.changes()) {
      for (const Index v : change->features.touched_vertices) vertex_[v] = first(features.vertex_elements(v));
      for (const Index e : change->features.touched_edges) edge_[e] = first(features.edge_elements(e));
      for (const Index f : change->features.touched_triangles) triangle_[f] = first(features.triangle_elements(f));
    }
    return;
  }
  for (Index v = 0; v < features.vertex_slots(); ++v) vertex_[v] = first(features.vertex_elements(v));
  for (Index e = 0; e < features.edge_slots(); ++e) edge_[e] = first(features.edge_elements(e));
  for (Index f = 0; f < features.triangle_slots(); ++f) triangle_[f] = first(features.triangle_elements(f));
}

}  // namespace volccd::detail
