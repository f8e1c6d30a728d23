#include <volccd/culling/detail/o_set_blocks.hpp>

#include <algorithm>

namespace volccd::detail {

void OSetBlocks::Writer::break_row() {
  const Index owner = rows_[row_];
  end_row();
  flush();
  begin_row(owner);
}

void OSetBlocks::Writer::flush() {
  if (pairs_ != 0) blocks_.blocks_.push_back({{rows_.begin(), rows_.end()}, pairs_, blocks_.epoch_, kind_});
  blocks_.written_ += pairs_;
  rows_.clear();
  pairs_ = 0;
}

void OSetBlocks::start_over(const Features& features) {
  *this = OSetBlocks();
  vertices_.resize(features.vertex_slots(), 0);
  triangles_.resize(features.triangle_slots(), 0);
  edges_.resize(features.edge_slots(), 0);
}

void OSetBlocks::settle() {
  blocks_.shrink_to_fit();
  sound_pairs_ = written_;
  sound_blocks_ = blocks_.size();
  written_ = renewals_ = 0;
}

void OSetBlocks::next_epoch(const Features& features) {
  if (epoch_ == kLastEpoch) compact();
  ++epoch_;
  vertices_.resize(features.vertex_slots(), 0);
  triangles_.resize(features.triangle_slots(), 0);
  edges_.resize(features.edge_slots(), 0);
}

template <class Visit>
void OSetBlocks::visit(const Block& block, Visit&& pair) const {
  const bool all = block.epoch == epoch_;
  for (std::size_t at = 0; at < block.rows.size();) {
    const Index owner = block.rows[at];
    const std::size_t end = at + 2 + block.rows[at + 1];
    for (std::size_t i = at + 2; i < end; ++i)
      if (all || holds(block, owner, block.rows[i])) pair(owner, block.rows[i]);
    at = end;
  }
}

bool OSetBlocks::holds(const Block& block, Index owner, Index partner) const {
  const bool ee = block.kind == Rows::edge;
  const Index a = ee ? std::min(owner, partner) : block.kind == Rows::vertex ? owner : partner;
  const Index b = ee ? std::max(owner, partner) : block.kind == Rows::vertex ? partner : owner;
  return (ee ? edges_[a] : vertices_[a]) <= block.epoch && (ee ? edges_[b] : triangles_[b]) <= block.epoch;
}

void OSetBlocks::append(std::size_t block, TestBatch& out) const {
  const Block& source = blocks_[block];
  switch (source.kind) {
    case Rows::vertex: return visit(source, [&](Index v, Index f) { out.vf.push_back({v, f}); });
    case Rows::triangle: return visit(source, [&](Index f, Index v) { out.vf.push_back({v, f}); });
    case Rows::edge:
      return visit(source, [&](Index a, Index b) { out.ee.push_back({std::min(a, b), std::max(a, b)}); });
  }
}

void OSetBlocks::count(std::size_t& vf, std::size_t& ee) const {
  vf = ee = 0;
  for (const Block& block : blocks_) {
    std::size_t& count = block.kind == Rows::edge ? ee : vf;
    if (block.epoch == epoch_) {
      count += block.pairs;
    } else {
      visit(block, [&](Index, Index) { ++count; });
    }
  }
}

std::size_t OSetBlocks::bytes() const {
  std::size_t bytes = blocks_.capacity() * sizeof(Block);
  for (const Block& block : blocks_) bytes += block.rows.capacity() * sizeof(Index);
  for (const auto* epochs : {&vertices_, &triangles_, &edges_}) bytes += epochs->capacity() * sizeof(Epoch);
  return bytes;
}

void OSetBlocks::compact_if_stale(const Features& features) {
  const std::size_t live = std::size_t{features.vertex_count()} + features.triangle_count() + features.edge_count();
  const bool stale = renewals_ > live / 4 + 1024;
  const bool grown = written_ > sound_pairs_ / 4 + kBlockPairs;
  const bool scattered = blocks_.size() > 2 * sound_blocks_ + 64;
  if (stale || grown || scattered) compact();
}

void OSetBlocks::compact() {
  std::vector<Block> old;
  old.swap(blocks_);
  written_ = 0;
  Writer writers[] = {{*this, Rows::vertex}, {*this, Rows::triangle}, {*this, Rows::edge}};
  for (Block& block : old) {
    Writer& writer = writers[static_cast<std::size_t>(block.kind)];
    Index row = kNone;
    visit(block, [&](Index owner, Index partner) {
      if (owner != row) {
        if (row != kNone) writer.end_row();
        writer.begin_row(row = owner);
      }
      writer.add(partner);
    });
    if (row != kNone) writer.end_row();
    block = {};
  }
  for (Writer& writer : writers) writer.flush();
  for (Block& block : blocks_) block.epoch = 0;
  epoch_ = 0;
  for (auto* epochs : {&vertices_, &triangles_, &edges_}) std::fill(epochs->begin(), epochs->end(), Epoch{0});
  settle();
}

}  // namespace volccd::detail
