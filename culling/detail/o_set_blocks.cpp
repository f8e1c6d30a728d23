#include <volccd/culling/detail/o_set_blocks.hpp>

#include <algorithm>
#include <iterator>

namespace volccd::detail {

void OSetBlocks::Writer::break_row() {
  const Index owner = rows_[row_];
  end_row();
  flush();
  begin_row(owner);
}

void OSetBlocks::Writer::flush() {
  if (pairs_ != 0) part_.blocks_.push_back({{rows_.begin(), rows_.end()}, pairs_, part_.epoch_, kind_});
  part_.written_ += pairs_;
  rows_.clear();
  pairs_ = 0;
}

OSetBlocks::Part OSetBlocks::new_part() const {
  Part part;
  part.epoch_ = epoch_;
  return part;
}

void OSetBlocks::append(Part&& part) {
  std::move(part.blocks_.begin(), part.blocks_.end(), std::back_inserter(blocks_));
  written_ += part.written_;
}

void OSetBlocks::start_over(const Features& features) {
  *this = OSetBlocks();
  vertices_.resize(features.vertex_slots(), 0);
  triangles_.resize(features.triangle_slots(), 0);
  edges_.resize(features.edge_slots(), 0);
}

void OSetBlocks::settle() {
  blocks_.shrink_to_fit();
  baseline_pairs_ = written_;
  baseline_blocks_ = blocks_.size();
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
  const bool edges = block.kind == Rows::edge, vertices = block.kind == Rows::vertex;
  const Epoch* const owners = (edges ? edges_ : vertices ? vertices_ : triangles_).data();
  const Epoch* const partners = (edges ? edges_ : vertices ? triangles_ : vertices_).data();
  const Epoch epoch = block.epoch;
  const Index* const last = block.rows.data() + block.rows.size();
  for (const Index* row = block.rows.data(); row != last;) {
    const Index owner = row[0];
    const Index *next = row + 2, *const end = next + row[1];
    row = end;
    if (epoch == epoch_) {
      for (; next != end; ++next) pair(owner, *next);
    } else if (owners[owner] <= epoch) {
      for (; next != end; ++next)
        if (partners[*next] <= epoch) pair(owner, *next);
    }
  }
}

void OSetBlocks::append(std::size_t block, TestBatch& out) const {
  const Block& source = blocks_[block];
  std::vector<FeaturePair>& list = source.kind == Rows::edge ? out.ee : out.vf;
  const std::size_t before = list.size();
  list.resize(before + source.pairs);
  FeaturePair* next = list.data() + before;  // direct writes, because push_back would take most of the time
  switch (source.kind) {
    case Rows::vertex: visit(source, [&](Index v, Index f) { *next++ = {v, f}; }); break;
    case Rows::triangle: visit(source, [&](Index f, Index v) { *next++ = {v, f}; }); break;
    case Rows::edge: visit(source, [&](Index a, Index b) { *next++ = {std::min(a, b), std::max(a, b)}; }); break;
  }
  list.resize(static_cast<std::size_t>(next - list.data()));
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
  const bool grown = written_ > baseline_pairs_ / 4 + kBlockPairs;
  const bool scattered = blocks_.size() > 2 * baseline_blocks_ + 64;
  if (stale || grown || scattered) compact();
}

void OSetBlocks::compact() {
  std::vector<Block> old;
  old.swap(blocks_);
  written_ = 0;
  Part part = new_part();
  Writer writers[] = {{part, Rows::vertex}, {part, Rows::triangle}, {part, Rows::edge}};
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
  append(std::move(part));
  for (Block& block : blocks_) block.epoch = 0;
  epoch_ = 0;
  for (auto* epochs : {&vertices_, &triangles_, &edges_}) std::fill(epochs->begin(), epochs->end(), Epoch{0});
  settle();
}

}  // namespace volccd::detail
