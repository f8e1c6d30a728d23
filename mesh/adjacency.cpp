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
  AdjacencyTest built;
  std::size_t most = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) most = std::max(most, mesh.vertices(o).size());
  built.stride_ = most <= 4 ? 4 : 8;
  built.ids_.assign(std::size_t{mesh.element_slots()} * built.stride_, kNone);
  for (Index o = 0; o < mesh.element_slots(); ++o) built.store(mesh, o);
  if (most > kBlock) {
    built.large_.clear(mesh.element_slots(), 0);
    std::vector<Index> all(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o) all[o] = o;
    built.update_large(mesh, all);
  }
  *this = std::move(built);
}

void AdjacencyTest::update(const Mesh& mesh, std::span<const Index> slots) {
  std::size_t most = 0;
  for (Index o : slots) most = std::max(most, mesh.vertices(o).size());
  if (most > stride_ && (stride_ == 4 || large_.size() == 0)) return build(mesh);
  ids_.resize(std::size_t{mesh.element_slots()} * stride_, kNone);
  if (large_.size() != 0) update_large(mesh, slots);
  for (Index o : slots) store(mesh, o);
}

void AdjacencyTest::store(const Mesh& mesh, Index o) noexcept {
  const std::span<const Index> vertices = mesh.vertices(o);
  Index* const block = ids_.data() + std::size_t{o} * stride_;
  const std::size_t held = std::min<std::size_t>(vertices.size(), stride_);
  std::fill(std::copy_n(vertices.begin(), held, block), block + stride_, vertices.empty() ? kNone : vertices[0]);
}

/// All or nothing.
void AdjacencyTest::update_large(const Mesh& mesh, std::span<const Index> slots) {
  std::vector<Index> sorted;  // vertices of one element after the other
  std::vector<std::size_t> ends(slots.size());
  std::size_t entries = 0;
  for (std::size_t k = 0; k < slots.size(); ++k) {
    const std::span<const Index> vertices = mesh.vertices(slots[k]);
    const std::size_t begin = sorted.size();
    if (vertices.size() > kBlock) sorted.insert(sorted.end(), vertices.begin(), vertices.end());
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.end());
    ends[k] = sorted.size();
    entries += large_.room_for(slots[k], ends[k] - begin);
  }
  large_.reserve(mesh.element_slots(), entries);
  large_.extend(mesh.element_slots());
  for (std::size_t k = 0; k < slots.size(); ++k) {
    const std::size_t begin = k == 0 ? 0 : ends[k - 1];
    large_.assign(slots[k], std::span(sorted).subspan(begin, ends[k] - begin));
  }
  large_.compact_if_sparse();
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
