// Many short lists of indices in one array.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Room that arrays get beyond their size when they are built, so that the first changes do not copy all of them.
constexpr std::size_t with_spare(std::size_t n) { return n + n / 16; }

/// List i is pool[i]. A list that outgrows its capacity moves to the end of the array. If compact_if_sparse() is called
/// after each change, memory stays within a constant factor of the sum of the lists, and a change takes amortised time
/// proportional to the length of the lists that it changes. Every change invalidates spans. A member that throws
/// (std::bad_alloc, or Error if the array would exceed 2^32 entries) leaves the lists as they were.
class IncidencePool {
 public:
  std::size_t size() const { return lists_.size(); }
  std::span<const Index> operator[](std::size_t i) const { return {data_.data() + lists_[i].begin, lists_[i].size}; }

  /// Starts over with empty lists of the given capacities; fill with append().
  void layout(std::span<const Index> capacities);
  /// Starts over with `lists` empty lists, and room for `entries` altogether; fill with push_back().
  void clear(std::size_t lists, std::size_t entries);
  /// Appends empty lists, up to n.
  void extend(std::size_t n) {
    if (n > lists_.size()) lists_.resize(n);
  }

  /// At the end of list i, where all lists behind it are still empty: the fast way to fill them one after the other.
  void push_back(std::size_t i, Index value) {
    if (lists_[i].capacity == 0) lists_[i].begin = static_cast<Index>(data_.size());
    data_.push_back(value);
    lists_[i].capacity = ++lists_[i].size;
    ++used_;
  }
  /// At the end of list i, which has room for it.
  void append(std::size_t i, Index value) {
    data_[lists_[i].begin + lists_[i].size++] = value;
    ++used_;
  }
  /// Reserves memory for n lists and for `entries` more entries: the sum of room_for() over the lists that a change
  /// lets grow. Changes within it do not throw.
  void reserve(std::size_t n, std::size_t entries);
  /// Entries that list i, which need not exist yet, takes to grow to `size`.
  std::size_t room_for(std::size_t i, std::size_t size) const {
    return i < lists_.size() && size <= lists_[i].capacity ? 0 : size + size / 2;
  }
  /// Compacts the array if more than half of it is not in use. Does nothing if there is no memory for that.
  void compact_if_sparse() noexcept;

  /// List i and `values` ascend. Before insert() none of the values is in the list, before erase() all are.
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
  std::size_t used_ = 0;  ///< sum of sizes
};

}  // namespace volccd::detail
