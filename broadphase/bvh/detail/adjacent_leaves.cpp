#include <volccd/broadphase/bvh/detail/adjacent_leaves.hpp>

#include <algorithm>

#include <volccd/mesh/tables/group_by_key.hpp>

namespace volccd::detail {

namespace {
/// The table is made anew when more than 1/kForgottenDenominator of its leaves were forgotten.
constexpr Index kForgottenDenominator = 8;
}  // namespace

void AdjacentLeaves::clear() {
  elements_ = 0;
  forgotten_ = 0;
  known_.clear();
}

void AdjacentLeaves::update(std::span<const Index> slots, Index leaf_size, const Adjacency& adjacency, Index vertices,
                            Executor& executor) {
  if (slots.size() > kMaxElements) return clear();
  const Index elements = static_cast<Index>(slots.size());
  const Index leaves = (elements + leaf_size - 1) / leaf_size, blocks = (elements + kBlock - 1) / kBlock;
  if (elements_ == elements && forgotten_ <= leaves / kForgottenDenominator) return;
  elements_ = elements;
  leaf_size_ = leaf_size;
  forgotten_ = 0;
  known_.assign(elements, 1);
  begins_.resize(elements);
  sizes_.resize(elements);
  if (blocks_.size() < blocks) blocks_.resize(blocks);
  // A place is kMaskRow times the leaf, plus the place of the element there.
  const auto add_places = [&](std::size_t, std::size_t begin, std::size_t end, auto&& add) {
    for (Index p = static_cast<Index>(begin); p < end; ++p)
      if (slots[p] != kNone)
        for (const Index v : adjacency.vertices(slots[p]))
          add(KeyValue{v, (p - p % leaf_size) * kMaskRow + p % leaf_size});
  };
  IncidencePool places;
  group_by_key(elements, vertices, std::size_t{elements} * 4, executor, add_places, places);
  if (scratch_.size() < executor.workers()) scratch_.resize(executor.workers());
  for (Scratch& scratch : scratch_) scratch.entries.assign(elements, kNone);
  executor.parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end, unsigned worker) {
    for (std::size_t b = begin; b < end; ++b)
      make_block(slots, adjacency, places, static_cast<Index>(b), scratch_[worker]);
  });
}

/// Sets scratch.vertices to the vertices of a leaf, each with bit 8 i for every element i that has it.
void AdjacentLeaves::collect_vertices(std::span<const Index> slots, const Adjacency& adjacency, Index leaf,
                                      Scratch& scratch) const {
  scratch.vertices.clear();
  const Index end = std::min(leaf + leaf_size_, elements_);
  for (Index p = leaf; p < end; ++p) {
    if (slots[p] == kNone) continue;
    for (const Index v : adjacency.vertices(slots[p])) {
      const auto at = std::find_if(scratch.vertices.begin(), scratch.vertices.end(),
                                   [&](const LeafVertex& listed) { return listed.vertex == v; });
      const std::uint64_t bit = std::uint64_t{1} << kMaskRow * (p - leaf);
      if (at == scratch.vertices.end())
        scratch.vertices.push_back({v, bit});
      else
        at->elements |= bit;
    }
  }
}

/// Makes the rows of one block from the places by vertex. The entries in `scratch` are kNone before and after.
void AdjacentLeaves::make_block(std::span<const Index> slots, const Adjacency& adjacency, const IncidencePool& places,
                                Index number, Scratch& scratch) {
  Block& block = blocks_[number];
  block.leaves.clear();
  block.masks.clear();
  const Index first = (number * kBlock + leaf_size_ - 1) / leaf_size_ * leaf_size_;
  const Index last = std::min((number + 1) * kBlock, elements_);
  for (Index leaf = first; leaf < last; leaf += leaf_size_) {
    const std::size_t row = block.leaves.size();
    begins_[leaf] = static_cast<Index>(row);
    collect_vertices(slots, adjacency, leaf, scratch);
    for (const LeafVertex& shared : scratch.vertices)
      for (const Index place : places[shared.vertex]) {
        if (place < leaf * kMaskRow) continue;
        Index& entry = scratch.entries[place / kMaskRow];
        if (entry == kNone) {
          entry = static_cast<Index>(block.leaves.size());
          block.leaves.push_back(place / kMaskRow);
          block.masks.push_back(0);
        }
        block.masks[entry] |= shared.elements << place % kMaskRow;
      }
    sizes_[leaf] = static_cast<Index>(block.leaves.size() - row);
    for (std::size_t k = row; k < block.leaves.size(); ++k) scratch.entries[block.leaves[k]] = kNone;
    const std::size_t padded = (block.leaves.size() + kPadding - 1) / kPadding * kPadding;
    block.leaves.resize(padded, kNone);
    block.masks.resize(padded);
  }
}

void AdjacentLeaves::remove(Index begin, Index end) {
  for (Index p = begin - begin % leaf_size_; p < std::min(end, elements_); p += leaf_size_) {
    forgotten_ += known_[p];
    known_[p] = 0;
  }
}

}  // namespace volccd::detail
