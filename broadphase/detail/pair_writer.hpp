// The pairs that a step asks for, and their output.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/query/roles/broad_phase.hpp>

namespace volccd::detail {

/// Which pairs a step asks for.
struct PairRules {
  const Adjacency* adjacency;  ///< null: adjacent pairs are included
  const FilterKeys* keys;      ///< null: the filter drops nothing
  bool self_pairs;             ///< whether self pairs (o, o) are included

  PairRules(const Step& step, const FilterKeys& filter)
      : adjacency(step.range == PairRange::nonadjacent ? &step.adjacency() : nullptr),
        keys(filter.trivial() ? nullptr : &filter),
        self_pairs(step.range == PairRange::every) {}

  bool included(Index a, Index b) const {
    if (adjacency && adjacency->adjacent(a, b)) return false;
    return !keys || keys->allowed(keys->key(a), keys->key(b));
  }
  /// Whether the filter may include pairs of elements with these keys.
  bool may_include(std::int32_t a, std::int32_t b) const { return !keys || keys->allowed(a, b); }
};

/// The pair with a <= b, computed without a branch, because it would be mispredicted half of the time.
inline ElementPair ordered(Index a, Index b) {
  const Index swapped = (a ^ b) & (Index{0} - Index{b < a});
  return {a ^ swapped, b ^ swapped};
}

/// Collects the pairs of a block, and appends them to the worker's list.
class PairWriter {
 public:
  /// Maximum number of pairs that a kernel may write before it calls written().
  static constexpr std::size_t kRoom = 64;

  explicit PairWriter(Work& work) : out_(work.pairs) {}
  PairWriter(const PairWriter&) = delete;
  PairWriter& operator=(const PairWriter&) = delete;

  /// Address at which the next kRoom pairs can be written. Two more entries may be overwritten.
  ElementPair* room() {
    if (size_ + kRoom > kCapacity) flush();
    return pairs_.data() + size_;
  }
  /// Accepts the pairs between room() and `end`, each with a <= b.
  void written(const ElementPair* end) { size_ = static_cast<std::size_t>(end - pairs_.data()); }

  void push(Index a, Index b) {
    ElementPair* const next = room();
    *next = ordered(a, b);
    written(next + 1);
  }

  /// Appends what is left. To be called once the block is done.
  void flush() {
    out_.insert(out_.end(), pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ = 0;
  }

 private:
  static constexpr std::size_t kCapacity = 1024;

  std::vector<ElementPair>& out_;
  std::size_t size_ = 0;
  std::array<ElementPair, kCapacity + 2> pairs_;
};

/// Writes the self pairs (o, o) that the step asks for of the elements at the positions [begin, end).
inline void write_self_pairs(std::span<const Index> slots, const PairRules& rules, std::size_t begin, std::size_t end,
                             PairWriter& out) {
  for (std::size_t p = begin; p < std::min(end, slots.size()); ++p)
    if (rules.included(slots[p], slots[p])) out.push(slots[p], slots[p]);
}

}  // namespace volccd::detail
