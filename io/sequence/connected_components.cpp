#include <volccd/io/sequence/connected_components.hpp>

#include <algorithm>
#include <numeric>

namespace volccd {

ConnectedComponents::ConnectedComponents(SequenceReader& reader) : component_(reader.point_count(), -1) {
  // Disjoint sets of vertices; the representative of a set is its smallest member.
  std::vector<Index> parent(reader.point_count());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto representative = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  SequenceCells cells;
  for (int k = 0; k < reader.frame_count(); ++k) {
    if (k > 0 && reader.same_cells(k, k - 1)) continue;
    reader.read_cells(k, cells);
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (const Index v : cells.vertices(i)) {
        component_[v] = 0;
        const auto [low, high] = std::minmax({representative(cells.vertices(i).front()), representative(v)});
        parent[high] = low;
      }
  }
  for (Index v = 0; v < reader.point_count(); ++v) {
    if (component_[v] < 0) continue;
    const Index first = representative(v);
    component_[v] = first == v ? count_++ : component_[first];
  }
}

void ConnectedComponents::assign(SequenceCells& cells) const {
  for (std::size_t i = 0; i < cells.size(); ++i) cells.objects[i] = component_[cells.vertices(i).front()];
}

}  // namespace volccd
