// Hash table from an ascending tuple of vertex slots (an edge, a triangle) to the slot of the feature.
#pragma once

#include <array>
#include <span>

#include <volccd/core/random.hpp>
#include <volccd/mesh/tables/slot_table.hpp>

namespace volccd::detail {

/// Compares the components explicitly, because g++ calls memcmp for the operator== of std::array.
template <std::size_t N>
requires(N == 2 || N == 3) bool same_tuple(const std::array<Index, N>& x, const std::array<Index, N>& y) {
  return x[0] == y[0] && x[1] == y[1] && x[N - 1] == y[N - 1];
}

/// The tuples themselves are stored in the caller's array, which is an argument of every call: tuples[slot] must be the
/// tuple of each slot in the table. Expected time O(1) per call.
template <std::size_t N>
requires(N == 2 || N == 3) class TupleTable {
 public:
  using Tuple = std::array<Index, N>;
  using Tuples = std::span<const Tuple>;

  Index find(const Tuple& tuple, Tuples tuples) const {
    return table_.find(hash(tuple), [&](Index slot) { return same_tuple(tuples[slot], tuple); });
  }

  /// Slot of the tuple. If the tuple is not in the table, it gets `slot`, and the caller must store it at tuples[slot]
  /// before the next call.
  Index find_or_insert(const Tuple& tuple, Index slot, Tuples tuples) {
    return table_.find_or_insert(
        hash(tuple), slot, [&](Index other) { return same_tuple(tuples[other], tuple); },
        [&](Index other) { return hash(tuples[other]); });
  }

  /// Removes a slot, which must be in the table.
  void erase(Index slot, Tuples tuples) {
    table_.erase(slot, [&](Index other) { return hash(tuples[other]); });
  }

  /// Replaces the contents by all of `tuples`, which are distinct. The table does not depend on the number of threads.
  void fill(Tuples tuples, Executor& executor) {
    table_.fill(
        static_cast<Index>(tuples.size()), [&](Index slot) { return hash(tuples[slot]); }, executor);
  }

  std::size_t size() const { return table_.size(); }
  std::size_t bytes() const { return table_.bytes(); }

 private:
  static std::uint32_t hash(const Tuple& tuple) {
    std::uint64_t h = std::uint64_t{tuple[0]} << 32 | tuple[1];
    if constexpr (N == 3) h = mix(h) + tuple[2];
    return static_cast<std::uint32_t>(mix(h) >> 32);
  }

  SlotTable table_;
};

}  // namespace volccd::detail
