// Many short lists of indices in a single array.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Capacity of an array that is built with n entries: n plus a reserve, so that the first changes do not reallocate it.
constexpr std::size_t with_spare(std::size_t n) { return n + n / 16; }

/// List i is pool[i]. A list that outgrows its capacity moves to the end of the array. If compact_if_sparse() is called
/// after each change, memory stays within a constant factor of the total length of the lists, and a change takes
/// amortised time proportional to the length of the changed lists. Every change invalidates spans. A member that throws
/// (std::bad_alloc, or Error if the array would exceed 2^32 entries) leaves the lists unchanged.
class IncidencePool {
 public:
  std::size_t size() const { return lists_.size(); }
  std::span<const Index> operator[](std::size_t i) const { return {data_.data() + lists_[i].begin, lists_[i].size}; }

  /// Replaces all lists by empty lists with the given capacities, to be filled with append().
  void layout(std::span<const Index> capacities);
  /// Replaces all lists by `lists` empty lists, with memory for `entries` entries in total, to be filled with
  /// push_back().
  void clear(std::size_t lists, std::size_t entries);
  /// Appends empty lists until there are n.
  void extend(std::size_t n) {
    if (n > lists_.size()) lists_.resize(n);
  }

  /// Appends a value to list i. All lists after i must be empty. This is the fastest way to fill the lists one after
  /// another.
  void push_back(std::size_t i, Index value) {
    if (lists_[i].capacity == 0) lists_[i].begin = static_cast<Index>(data_.size());
    data_.push_back(value);
    lists_[i].capacity = ++lists_[i].size;
    ++used_;
  }
  /// Appends a value to list i, which must have free capacity.
  void append(std::size_t i, Index value) {
    data_[lists_[i].begin + lists_[i].size++] = value;
    ++used_;
  }
  /// Reserves memory for n lists and for `entries` more entries: the sum of room_for() over all lists that a change
  /// enlarges. Changes within this reserve do not throw.
  void reserve(std::size_t n, std::size_t entries);
  /// Number of new entries in the array that list i needs to grow to `size`; list i need not exist yet.
  std::size_t room_for(std::size_t i, std::size_t size) const {
    return i < lists_.size() && size <= lists_[i].capacity ? 0 : size + size / 2;
  }
  /// Compacts the array if more than half of it is unused. Does nothing if there is not enough memory.
  void compact_if_sparse() noexcept;

  /// List i and `values` must be ascending. insert(): none of the values is in the list. erase(): all of them are.
  void insert(std::size_t i, std::span<const Index> values);
  void erase(std::size_t i, std::span<const Index> values) noexcept;
  /// Replaces list i.
  void assign(std::size_t i, std::span<const Index> values);

  std::size_t bytes() const { return lists_.capacity() * sizeof(List) + data_.capacity() * sizeof(Index); }

 private:
  struct List {
    Index begin = 0, size = 0, capacity = 0;
  };
  void relocate(std::size_t i, std::size_t capacity);

  std::vector<List> lists_;
  std::vector<Index> data_;
  std::size_t used_ = 0;  ///< total length of all lists
};

}  // namespace volccd::detail
