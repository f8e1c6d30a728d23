#include <volccd/mesh/adjacency.hpp>

#include <algorithm>
#include <array>

#include <volccd/mesh/detail/reserve.hpp>

namespace volccd {

namespace {

std::size_t largest(std::span<const ElementSpec> elements) {
  std::size_t most = 0;
  for (const ElementSpec& element : elements) most = std::max(most, element.vertices.size());
  return most;
}

}  // namespace

void Adjacency::build(const Mesh& mesh) {
  *this = Adjacency();
  std::size_t most = 0;
  for (Index o = 0; o < mesh.element_slots(); ++o) most = std::max(most, mesh.vertices(o).size());
  if (most > block_) block_ = kMaxBlock;
  const std::size_t size = std::size_t{mesh.element_slots()} * block_;
  ids_.reserve(detail::with_spare(size));
  ids_.resize(size);
  if (most > kMaxBlock) large_.clear(mesh.element_slots(), 0);
  for (Index o = 0; o < mesh.element_slots(); ++o) store(o, mesh.vertices(o));
}

void Adjacency::prepare(std::span<const ElementSpec> added, std::span<const Index> slots, Index element_slots) {
  const std::size_t most = largest(added), block = most > block_ ? kMaxBlock : block_;
  detail::reserve_more(ids_, element_slots * block - ids_.size());
  if (most <= kMaxBlock && large_.size() == 0) return;
  std::size_t entries = 0;
  for (std::size_t k = 0; k < added.size(); ++k)
    if (const std::size_t n = added[k].vertices.size(); n > kMaxBlock) entries += large_.room_for(slots[k], n);
  large_.reserve(element_slots, entries);
}

void Adjacency::commit(std::span<const Index> removed, std::span<const ElementSpec> added, std::span<const Index> slots,
                       Index element_slots) noexcept {
  const std::size_t most = largest(added);
  if (most > block_ && block_ != kMaxBlock) widen();
  ids_.resize(std::size_t{element_slots} * block_);
  if (most > kMaxBlock || large_.size() != 0) large_.extend(element_slots);
  for (const Index o : removed) store(o, {});
  for (std::size_t k = 0; k < added.size(); ++k) store(slots[k], added[k].vertices);
  large_.compact_if_sparse();
}

void Adjacency::store(Index o, std::span<const Index> vertices) {
  Index* const block = ids_.data() + std::size_t{o} * block_;
  const std::size_t held = std::min<std::size_t>(vertices.size(), block_);
  std::fill(std::copy_n(vertices.begin(), held, block), block + block_, vertices.empty() ? kNone : vertices[0]);
  if (large_.size() != 0) large_.assign(o, vertices.size() > kMaxBlock ? vertices : std::span<const Index>());
}

/// Changes blocks of four to blocks of eight, in the memory that prepare() has reserved. Proceeds from the last block
/// to the first, so that no block is overwritten before it is read.
void Adjacency::widen() noexcept {
  const std::size_t slots = ids_.size() / 4;
  ids_.resize(slots * kMaxBlock);
  for (std::size_t o = slots; o-- > 0;) {
    std::array<Index, 4> ids;
    std::copy_n(ids_.begin() + static_cast<std::ptrdiff_t>(4 * o), 4, ids.begin());
    const auto to = ids_.begin() + static_cast<std::ptrdiff_t>(kMaxBlock * o);
    std::fill_n(std::copy(ids.begin(), ids.end(), to), 4, ids[0]);
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
