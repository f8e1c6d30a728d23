// Many short lists of indices in a single array.
#pragma once

#include <cstddef>
#include <span>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {
class Executor;
}

namespace volccd::detail {

/// List i is pool[i]. A list that outgrows its capacity moves to the end of the array. If compact_if_sparse() is called
/// after each change, memory stays within a constant factor of the total length of the lists, and a change takes
/// amortised time proportional to the length of the changed lists. Every change invalidates spans. A member that throws
/// (std::bad_alloc, or Error if the array would exceed 2^32 entries) leaves the lists unchanged.
class IncidencePool {
 public:
  std::size_t size() const { return lists_.size(); }
  std::span<const Index> operator[](std::size_t i) const { return {data_.data() + lists_[i].begin, lists_[i].size}; }

  /// Replaces all lists by `lists` lists with `entries` entries in total, all of which are uninitialized. place() and
  /// entries() must set each of them.
  void allocate(std::size_t lists, std::size_t entries);
  /// After allocate(): list i consists of `size` entries from `begin` on. Threads may place different lists.
  void place(std::size_t i, std::size_t begin, std::size_t size) {
    lists_[i] = {static_cast<Index>(begin), static_cast<Index>(size), static_cast<Index>(size)};
  }
  /// Replaces all lists by lists of these lengths, placed one after another; their entries are uninitialized.
  void set_lengths(std::span<const Index> lengths, Executor& executor);
  /// The entries of all lists, in the order in which these were placed, until the first change.
  std::span<Index> entries() { return data_; }
  std::span<const Index> entries() const { return data_; }
  /// Appends empty lists until there are n.
  void extend(std::size_t n) {
    if (n > lists_.size()) lists_.resize(n, List{0, 0, 0});
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

  std::size_t bytes() const { return heap_bytes(lists_, data_); }

 private:
  struct List {
    Index begin, size, capacity;
  };
  void relocate(std::size_t i, std::size_t capacity);

  RawVector<List> lists_;
  RawVector<Index> data_;
  std::size_t used_ = 0;  ///< total length of all lists
};

}  // namespace volccd::detail
