#include <volccd/culling/o_set/detail/o_set_blocks.hpp>

#include <algorithm>
#include <utility>

namespace volccd::detail {

void OSetBlocks::Writer::break_row() {
  const Index owner = rows_[row_];
  flush();
  begin_row(owner);
}

void OSetBlocks::Writer::flush() {
  end_row();
  if (pairs_ != 0) part_.push_back({{rows_.data(), rows_.data() + end_}, pairs_, kind_});
  end_ = 0;
  pairs_ = 0;
}

void OSetBlocks::append(Part&& part) {
  for (Block& block : part) {
    block.epoch = epoch_;
    written_ += block.pairs;
    blocks_.push_back(std::move(block));
  }
}

void OSetBlocks::fit(const Features& features) {
  epochs(Owner::vertex).resize(features.vertex_slots(), 0);
  epochs(Owner::triangle).resize(features.triangle_slots(), 0);
  epochs(Owner::edge).resize(features.edge_slots(), 0);
}

void OSetBlocks::start_over(const Features& features) {
  *this = OSetBlocks();
  fit(features);
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
  fit(features);
}

template <class Visit>
void OSetBlocks::visit(const Block& block, Visit&& pair) const {
  constexpr Owner kPartners[] = {Owner::triangle, Owner::vertex, Owner::edge};
  const Epoch* const owners = epochs(block.kind).data();
  const Epoch* const partners = epochs(kPartners[static_cast<std::size_t>(block.kind)]).data();
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
  std::vector<FeaturePair>& list = source.kind == Owner::edge ? out.ee : out.vf;
  const std::size_t before = list.size();
  list.resize(before + source.pairs);
  FeaturePair* next = list.data() + before;  // direct writes, because push_back would take most of the time
  switch (source.kind) {
    case Owner::vertex: visit(source, [&](Index v, Index f) { *next++ = {v, f}; }); break;
    case Owner::triangle: visit(source, [&](Index f, Index v) { *next++ = {v, f}; }); break;
    case Owner::edge: visit(source, [&](Index a, Index b) { *next++ = {std::min(a, b), std::max(a, b)}; }); break;
  }
  list.resize(static_cast<std::size_t>(next - list.data()));
}

OSetCounts OSetBlocks::counts() const {
  OSetCounts counts;
  for (const Block& block : blocks_) {
    std::size_t& count = block.kind == Owner::edge ? counts.ee : counts.vf;
    if (block.epoch == epoch_)
      count += block.pairs;
    else
      visit(block, [&](Index, Index) { ++count; });
  }
  return counts;
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
  Part part;
  Writer writers[] = {{part, Owner::vertex}, {part, Owner::triangle}, {part, Owner::edge}};
  for (Block& block : old) {
    Writer& writer = writers[static_cast<std::size_t>(block.kind)];
    Index row = kNone;
    visit(block, [&](Index owner, Index partner) {
      if (owner != row) writer.begin_row(row = owner);
      writer.add(partner);
    });
    block = {};
  }
  for (Writer& writer : writers) writer.flush();
  append(std::move(part));
  for (Block& block : blocks_) block.epoch = 0;
  epoch_ = 0;
  for (std::vector<Epoch>& epochs : epochs_) std::fill(epochs.begin(), epochs.end(), Epoch{0});
  settle();
}

}  // namespace volccd::detail
