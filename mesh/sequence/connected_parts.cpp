#include <volccd/mesh/sequence/connected_parts.hpp>

#include <algorithm>
#include <numeric>

namespace volccd {

namespace {

/// Disjoint sets of vertex slots; the representative of a set is its smallest member.
class VertexSets {
 public:
  explicit VertexSets(Index n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }

  Index representative(Index v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void join(Index a, Index b) {
    const Index one = representative(a), other = representative(b);
    parent_[std::max(one, other)] = std::min(one, other);
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace

ConnectedParts::ConnectedParts(SequenceReader& reader) : component_(reader.point_count(), -1) {
  VertexSets sets(reader.point_count());
  std::vector<char> used(reader.point_count(), 0);
  SequenceCells cells;
  for (int k = 0; k < reader.step_count(); ++k) {
    if (k > 0 && reader.same_cells(k, k - 1)) continue;
    reader.read_cells(k, cells);
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (const Index v : cells.vertices(i)) {
        used[v] = 1;
        sets.join(cells.vertices(i).front(), v);
      }
  }
  // The representative of a set precedes its other members.
  for (Index v = 0; v < reader.point_count(); ++v) {
    if (!used[v]) continue;
    const Index first = sets.representative(v);
    component_[v] = first == v ? count_++ : component_[first];
  }
}

void ConnectedParts::assign(SequenceCells& cells) const {
  for (std::size_t i = 0; i < cells.size(); ++i) cells.parts[i] = component_[cells.vertices(i).front()];
}

}  // namespace volccd
