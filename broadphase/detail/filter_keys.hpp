// ObjectFilter::drops for element pairs, prepared: a small number for each element, and a table of allowed numbers.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Key of a pure element: the rank of its object's id. kMixed: an element with a vertex of another object, which is
/// never dropped. allowed(key(a), key(b)) == !filter.drops(topology, {a, b}).
class FilterKeys {
 public:
  static constexpr std::int32_t kMixed = -1;

  /// O(1) if neither filter nor topology changed since the last call. Returns whether keys or the table changed.
  bool update(const Step& step, bool topology_changed);

  /// Nothing is dropped; there are no keys.
  bool trivial() const { return filter_.trivial(); }
  std::int32_t key(Index slot) const { return keys_[slot]; }

  bool allowed(std::int32_t a, std::int32_t b) const {
    if (a == kMixed || b == kMixed) return true;
    const std::size_t i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return table_.empty() ? filter_.allows(objects_[i], objects_[j]) : table_[i * objects_.size() + j] != 0;
  }

  std::size_t bytes() const { return keys_.capacity() * 4 + objects_.capacity() * 4 + table_.capacity(); }

 private:
  void make_keys(const Topology& topology);
  void make_table();

  ObjectFilter filter_;
  bool keys_valid_ = false;
  std::vector<std::int32_t> keys_, objects_;
  std::vector<std::uint8_t> table_;  ///< objects_ squared; empty if that would be large
};

}  // namespace volccd::detail
