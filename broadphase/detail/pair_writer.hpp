// A worker's way to the sink: drops pairs that the query does not want, and hands on the rest in batches.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/mesh/adjacency.hpp>

namespace volccd::detail {

class PairWriter {
 public:
  /// `adjacency` is null if adjacent pairs are wanted, `keys` if no pair is dropped by the filter.
  void start(const AdjacencyTest* adjacency, const FilterKeys* keys, PairSink sink, unsigned worker) {
    adjacency_ = adjacency;
    keys_ = keys;
    sink_.emplace(sink);
    worker_ = worker;
    size_ = 0;
  }

  /// Takes the pair of elements a != b whose bounds overlap, or (o, o).
  void offer(Index a, Index b) {
    pairs_[size_] = a < b ? ElementPair{a, b} : ElementPair{b, a};
    bool wanted = true;
    if (adjacency_) wanted = !adjacency_->adjacent(a, b);
    if (keys_) wanted = wanted && keys_->allowed(keys_->key(a), keys_->key(b));
    size_ += wanted;
    if (size_ == pairs_.size()) flush();
  }

  void flush() {
    if (size_ > 0) (*sink_)({pairs_.data(), size_}, worker_);
    size_ = 0;
  }

 private:
  const AdjacencyTest* adjacency_ = nullptr;
  const FilterKeys* keys_ = nullptr;
  std::optional<PairSink> sink_;
  unsigned worker_ = 0;
  std::size_t size_ = 0;
  std::array<ElementPair, BroadPhase::kMaxBatch> pairs_;
};

/// One writer for each worker. Reused from query to query.
class PairWriters {
 public:
  void start(PairRange range, const AdjacencyTest& adjacency, const FilterKeys& keys, unsigned workers, PairSink sink) {
    writers_.resize(workers);
    for (unsigned w = 0; w < workers; ++w)
      writers_[w].start(range == PairRange::nonadjacent ? &adjacency : nullptr, keys.trivial() ? nullptr : &keys, sink, w);
  }

  PairWriter& operator[](unsigned worker) { return writers_[worker]; }

  /// Hands on what is left, on the calling thread.
  void finish() {
    for (PairWriter& writer : writers_) writer.flush();
  }

  std::size_t bytes() const { return writers_.capacity() * sizeof(PairWriter); }

 private:
  std::vector<PairWriter> writers_;
};

}  // namespace volccd::detail
