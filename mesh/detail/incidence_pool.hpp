// Many short lists of indices in one array.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// List i is pool[i]. A list that outgrows its capacity moves to the end of the array; when more than half of the array is
/// not in use, it is compacted, so that memory stays within a constant factor of what the lists hold and a change costs
/// amortised time proportional to the length of the lists that it touches. Spans are invalidated by every change.
/// Throws Error when the array would exceed 2^32 entries.
class IncidencePool {
 public:
  std::size_t size() const { return lists_.size(); }
  std::span<const Index> operator[](std::size_t i) const {
    return {data_.data() + lists_[i].begin, lists_[i].size};
  }

  /// Starts over with lists of the given final lengths, all empty yet; fill with append().
  void layout(std::span<const Index> lengths);
  /// Starts over with `lists` lists, and room for `entries` altogether.
  void clear(std::size_t lists, std::size_t entries);
  /// Appends empty lists, up to n.
  void extend(std::size_t n) {
    if (n > lists_.size()) lists_.resize(n);
  }

  /// At the end of list i.
  void append(std::size_t i, Index value) {
    if (lists_[i].size == lists_[i].capacity) grow(i);
    data_[lists_[i].begin + lists_[i].size++] = value;
    ++used_;
  }
  /// Into list i, which ascends; the value must not be in it yet.
  void insert(std::size_t i, Index value);
  /// Out of list i, which ascends; the value must be in it.
  void erase(std::size_t i, Index value);
  /// Replaces list i.
  void assign(std::size_t i, std::span<const Index> values);
  void clear_list(std::size_t i);

  std::size_t bytes() const { return lists_.capacity() * sizeof(List) + data_.capacity() * sizeof(Index); }

 private:
  struct List {
    Index begin = 0, size = 0, capacity = 0;
  };
  void grow(std::size_t i) {
    const std::size_t least = std::size_t{lists_[i].size} + 1;
    relocate(i, least + least / 2);
  }
  void relocate(std::size_t i, std::size_t capacity);
  void compact_if_sparse();

  std::vector<List> lists_;
  std::vector<Index> data_;
  std::size_t used_ = 0;  ///< sum of sizes
};

}  // namespace volccd::detail
