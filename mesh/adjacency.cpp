#include <volccd/mesh/adjacency.hpp>

#include <algorithm>

namespace volccd {

namespace {

constexpr std::size_t kBlock = 8;  // elements with more vertices are "large"

bool share_sorted(std::span<const Index> a, std::span<const Index> b) {
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i] == b[j]) return true;
    if (a[i] < b[j]) {
      ++i;
    } else {
      ++j;
    }
  }
  return false;
}

bool share_with_block(std::span<const Index> sorted, const Index* block) {
  return std::any_of(block, block + kBlock,
                     [&](Index v) { return std::binary_search(sorted.begin(), sorted.end(), v); });
}

}  // namespace

void AdjacencyTest::build(const Mesh& mesh) {
  std::size_t most = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) most = std::max(most, mesh.vertices(o).size());
  stride_ = most <= 4 ? 4 : 8;
  ids_.assign(std::size_t{mesh.element_slots()} * stride_, kNone);
  large_.clear(most > kBlock ? mesh.element_slots() : 0, 0);
  for (Index o = 0; o < mesh.element_slots(); ++o) store(mesh, o);
}

void AdjacencyTest::update(const Mesh& mesh, std::span<const Index> slots) {
  std::size_t most = 0;
  for (Index o : slots) most = std::max(most, mesh.vertices(o).size());
  if (most > stride_ && (stride_ == 4 || large_.size() == 0)) return build(mesh);
  ids_.resize(std::size_t{mesh.element_slots()} * stride_, kNone);
  if (large_.size() != 0) large_.extend(mesh.element_slots());
  for (Index o : slots) store(mesh, o);
}

void AdjacencyTest::store(const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  Index* const block = ids_.data() + std::size_t{o} * stride_;
  const std::size_t held = std::min<std::size_t>(vertices.size(), stride_);
  std::fill(std::copy_n(vertices.begin(), held, block), block + stride_, vertices.empty() ? kNone : vertices[0]);
  if (large_.size() == 0) return;
  std::vector<Index> sorted;
  if (vertices.size() > kBlock) {
    sorted.assign(vertices.begin(), vertices.end());
    std::sort(sorted.begin(), sorted.end());
  }
  large_.assign(o, sorted);
}

bool AdjacencyTest::adjacent_large(Index a, Index b) const {
  if (large_[a].empty() && large_[b].empty()) return detail::share_id<8>(block(a), block(b));
  if (large_[a].empty()) return share_with_block(large_[b], block(a));
  if (large_[b].empty()) return share_with_block(large_[a], block(b));
  return share_sorted(large_[a], large_[b]);
}

void adjacent_elements(const Mesh& mesh, const Features& features, Index o, std::vector<Index>& out) {
  out.clear();
  for (Index v : mesh.vertices(o)) {
    const std::span<const Index> elements = features.vertex_elements(v);
    out.insert(out.end(), elements.begin(), elements.end());
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace volccd
