#include <volccd/mesh/adjacency.hpp>

#include <algorithm>
#include <cstring>
#include <vector>

#include <volccd/mesh/tables/chunks.hpp>
#include <volccd/mesh/tables/group_by_key.hpp>

namespace volccd {

namespace {

std::size_t largest(std::span<const ElementSpec> elements) {
  std::size_t max = 0;
  for (const ElementSpec& element : elements) max = std::max(max, element.vertices.size());
  return max;
}

}  // namespace

void Adjacency::build(const Mesh& mesh, Executor& executor) {
  *this = Adjacency();
  const detail::Chunks chunks(mesh.element_slots());
  std::vector<std::size_t> sizes(chunks.count());  // largest number of vertices in each chunk
  chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
    std::size_t size = 0;
    for (Index o = static_cast<Index>(begin); o < end; ++o) size = std::max(size, mesh.vertices(o).size());
    sizes[c] = size;
  });
  const std::size_t max = sizes.empty() ? 0 : *std::max_element(sizes.begin(), sizes.end());
  if (max > block_) block_ = kMaxBlock;
  detail::resize_with_spare(ids_, std::size_t{mesh.element_slots()} * block_);
  chunks.for_each(executor, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (Index o = static_cast<Index>(begin); o < end; ++o) store_block(o, mesh.vertices(o));
  });
  if (max <= kMaxBlock) return;
  const auto add_vertices = [&](std::size_t, std::size_t begin, std::size_t end, auto&& add) {
    for (Index o = static_cast<Index>(begin); o < end; ++o)
      if (const std::span<const Index> vertices = mesh.vertices(o); vertices.size() > kMaxBlock)
        for (const Index v : vertices) add(detail::KeyValue{o, v});
  };
  const std::size_t slots = mesh.element_slots();
  detail::group_by_key(slots, slots, slots * max, executor, add_vertices, large_);
}

void Adjacency::prepare(std::span<const ElementSpec> added, std::span<const Index> slots, Index element_slots) {
  const std::size_t max = largest(added), block = max > block_ ? kMaxBlock : block_;
  detail::reserve_more(ids_, element_slots * block - ids_.size());
  if (max <= kMaxBlock && large_.size() == 0) return;
  std::size_t entries = 0;
  for (std::size_t k = 0; k < added.size(); ++k)
    if (const std::size_t n = added[k].vertices.size(); n > kMaxBlock) entries += large_.room_for(slots[k], n);
  large_.reserve(element_slots, entries);
}

void Adjacency::commit(std::span<const Index> removed, std::span<const ElementSpec> added, std::span<const Index> slots,
                       Index element_slots) noexcept {
  const std::size_t max = largest(added);
  if (max > block_ && block_ != kMaxBlock) widen();
  ids_.resize(std::size_t{element_slots} * block_);
  if (max > kMaxBlock || large_.size() != 0) large_.extend(element_slots);
  const auto store = [&](Index o, std::span<const Index> vertices) {
    store_block(o, vertices);
    if (large_.size() != 0) large_.assign(o, vertices.size() > kMaxBlock ? vertices : std::span<const Index>());
  };
  for (const Index o : removed) store(o, {});
  for (std::size_t k = 0; k < added.size(); ++k) store(slots[k], added[k].vertices);
  large_.compact_if_sparse();
}

void Adjacency::store_block(Index o, std::span<const Index> vertices) {
  Index* const block = ids_.data() + std::size_t{o} * block_;
  const std::size_t held = std::min<std::size_t>(vertices.size(), block_);
  std::fill(std::copy_n(vertices.begin(), held, block), block + block_, vertices.empty() ? kNone : vertices[0]);
}

/// Changes blocks of four to blocks of eight, in the memory that prepare() has reserved. Proceeds from the last block
/// to the first, so that no block is overwritten before it is read.
void Adjacency::widen() noexcept {
  const std::size_t slots = ids_.size() / 4;
  ids_.resize(slots * kMaxBlock);
  for (std::size_t o = slots; o-- > 0;) {
    Index* const to = ids_.data() + kMaxBlock * o;
    std::memmove(to, ids_.data() + 4 * o, 4 * sizeof(Index));
    std::fill_n(to + 4, 4, to[0]);
  }
  block_ = kMaxBlock;
}

/// Compares blocks of eight; the last block of a list overlaps the one before.
bool Adjacency::adjacent_large(Index a, Index b) const {
  const std::span<const Index> x = vertices(a), y = vertices(b);
  for (std::size_t i = 0; i < x.size(); i += kMaxBlock)
    for (std::size_t j = 0; j < y.size(); j += kMaxBlock)
      if (detail::share_id<kMaxBlock>(x.data() + std::min(i, x.size() - kMaxBlock),
                                      y.data() + std::min(j, y.size() - kMaxBlock)))
        return true;
  return false;
}

}  // namespace volccd
