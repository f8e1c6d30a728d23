// The pairs that a query requests, and their output to the sink.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Which pairs a query requests.
struct PairRules {
  const Adjacency* adjacency;  ///< null: adjacent pairs are included
  const FilterKeys* keys;      ///< null: the filter drops nothing
  bool self_pairs;             ///< whether self pairs (o, o) are included

  PairRules(PairRange range, const Topology& topology, const FilterKeys& filter)
      : adjacency(range == PairRange::nonadjacent ? &topology.adjacency() : nullptr),
        keys(filter.trivial() ? nullptr : &filter),
        self_pairs(range == PairRange::every) {}

  bool want(Index a, Index b) const {
    if (adjacency && adjacency->adjacent(a, b)) return false;
    return !keys || keys->allowed(keys->key(a), keys->key(b));
  }
  /// Whether the filter may include pairs of elements with these keys.
  bool may_want(std::int32_t a, std::int32_t b) const { return !keys || keys->allowed(a, b); }
};

/// The pair with a <= b, computed without a branch, because it would be mispredicted half of the time.
inline ElementPair ordered(Index a, Index b) {
  const Index swapped = (a ^ b) & (Index{0} - Index{b < a});
  return {a ^ swapped, b ^ swapped};
}

/// Collects the pairs of one worker in batches for the sink.
class PairWriter {
 public:
  /// Maximum number of pairs that a kernel may write before it calls written().
  static constexpr std::size_t kRoom = 64;

  void start(PairSink sink, unsigned worker) {
    sink_.emplace(sink);
    worker_ = worker;
    size_ = 0;
  }

  /// Address at which the next kRoom pairs can be written. Two more entries may be overwritten.
  ElementPair* room() {
    if (size_ + kRoom > BroadPhase::kMaxBatch) flush();
    return pairs_.data() + size_;
  }
  /// Accepts the pairs between room() and `end`, each with a <= b.
  void written(const ElementPair* end) { size_ = static_cast<std::size_t>(end - pairs_.data()); }

  void push(Index a, Index b) {
    ElementPair* const next = room();
    *next = ordered(a, b);
    written(next + 1);
  }

  void flush() {
    if (size_ > 0) (*sink_)({pairs_.data(), size_}, worker_);
    size_ = 0;
  }

 private:
  std::optional<PairSink> sink_;
  unsigned worker_ = 0;
  std::size_t size_ = 0;
  std::array<ElementPair, BroadPhase::kMaxBatch + 2> pairs_;
};

/// One writer for each worker. Reused for all queries.
class PairWriters {
 public:
  void start(unsigned workers, PairSink sink) {
    writers_.resize(workers);
    for (unsigned w = 0; w < workers; ++w) writers_[w].start(sink, w);
  }

  PairWriter& operator[](unsigned worker) { return writers_[worker]; }

  /// Flushes the remaining pairs, on the calling thread.
  void finish() {
    for (PairWriter& writer : writers_) writer.flush();
  }

  std::size_t bytes() const { return heap_bytes(writers_); }

 private:
  std::vector<PairWriter> writers_;
};

/// Writes the requested self pairs (o, o) of a list without gaps, in parallel.
inline void write_self_pairs(const ElementList& list, const PairRules& rules, Executor& executor,
                             PairWriters& writers) {
  constexpr std::size_t kGrain = 4096;
  if (!rules.self_pairs) return;
  const Index* const slots = list.slots();
  executor.parallel_for(list.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t p = begin; p < end; ++p)
      if (rules.want(slots[p], slots[p])) writers[w].push(slots[p], slots[p]);
  });
}

}  // namespace volccd::detail
