// A precomputed form of ObjectFilter::drops for element pairs: a small integer key for each element, and a table of
// allowed pairs of keys.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The key of an element is the rank of its object's id among all objects. It is kMixed for an element with a vertex
/// that belongs to another object; pairs with such an element are never dropped. allowed(key(a), key(b)) ==
/// !filter.drops(topology, {a, b}).
class FilterKeys {
 public:
  static constexpr std::int32_t kMixed = -1;

  /// Updates the keys for a step; O(1) if neither filter nor topology changed since the last call. Returns whether the
  /// keys or the table changed.
  bool update(const Step& step, bool topology_changed);

  /// True if the filter drops nothing; then there are no keys.
  bool trivial() const { return filter_.trivial(); }
  std::int32_t key(Index slot) const { return keys_[slot]; }

  bool allowed(std::int32_t a, std::int32_t b) const {
    if (a == kMixed || b == kMixed) return true;
    const std::size_t i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return table_.empty() ? filter_.allows(objects_[i], objects_[j]) : table_[i * objects_.size() + j] != 0;
  }

  std::size_t bytes() const { return heap_bytes(keys_, objects_, table_); }

 private:
  void make_keys(const Topology& topology);

  ObjectFilter filter_;
  bool keys_valid_ = false;
  std::vector<std::int32_t> keys_, objects_;
  std::vector<std::uint8_t> table_;  ///< square table over objects_; empty if it would be too large
};

}  // namespace volccd::detail
