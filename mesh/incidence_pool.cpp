#include <volccd/mesh/incidence_pool.hpp>

#include <algorithm>
#include <cassert>
#include <new>
#include <utility>
#include <vector>

#include <volccd/core/error.hpp>
#include <volccd/mesh/tables/chunks.hpp>

namespace volccd::detail {

namespace {

void check_size(std::size_t entries) {
  if (entries >= kNone) throw Error("mesh too large: more than 2^32 incidences of features and elements");
}

constexpr std::size_t kSmall = 1024;  // arrays smaller than this are not compacted
constexpr std::size_t kLong = 32;     // from this length on a binary search is faster than a linear search

}  // namespace

void IncidencePool::set_lengths(std::span<const Index> lengths, Executor& executor) {
  const Chunks chunks(lengths.size());
  std::vector<std::size_t> sums(chunks.count());
  chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
    std::size_t sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += lengths[i];
    sums[c] = sum;
  });
  std::size_t total = 0;
  for (std::size_t& sum : sums) total += std::exchange(sum, total);
  allocate(lengths.size(), total);
  chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
    std::size_t position = sums[c];
    for (std::size_t i = begin; i < end; position += lengths[i++]) place(i, position, lengths[i]);
  });
}

void IncidencePool::allocate(std::size_t lists, std::size_t entries) {
  check_size(entries);
  *this = IncidencePool();
  resize_with_spare(lists_, lists);
  data_.reserve(entries + entries / 8);
  data_.resize(entries);
  used_ = entries;
}

void IncidencePool::reserve(std::size_t n, std::size_t entries) {
  check_size(data_.size() + entries);
  if (n > lists_.size()) reserve_more(lists_, n - lists_.size());
  reserve_more(data_, entries);
}

void IncidencePool::insert(std::size_t i, std::span<const Index> values) {
  const std::size_t size = lists_[i].size + values.size();
  if (size > lists_[i].capacity) relocate(i, size + size / 2);
  Index* const first = data_.data() + lists_[i].begin;
  // Merges from the end; the values before the smallest new value are not moved.
  Index* from = first + lists_[i].size;
  Index* to = first + size;
  for (std::size_t k = values.size(); k != 0;) {
    if (from != first && from[-1] > values[k - 1]) {
      *--to = *--from;
    } else {
      *--to = values[--k];
    }
  }
  lists_[i].size = static_cast<Index>(size);
  used_ += values.size();
}

void IncidencePool::erase(std::size_t i, std::span<const Index> values) noexcept {
  Index* const last = data_.data() + lists_[i].begin + lists_[i].size;
  Index* from = data_.data() + lists_[i].begin;
  if (lists_[i].size > kLong) from = std::lower_bound(from, last, values.front());
  Index* to = from;
  for (std::size_t k = 0; from != last && k != values.size(); ++from) {
    if (*from == values[k]) {
      ++k;
    } else {
      *to++ = *from;
    }
  }
  to = std::copy(from, last, to);
  assert(last - to == static_cast<std::ptrdiff_t>(values.size()));
  lists_[i].size -= static_cast<Index>(last - to);
  used_ -= static_cast<std::size_t>(last - to);
}

void IncidencePool::assign(std::size_t i, std::span<const Index> values) {
  if (lists_[i].capacity < values.size()) relocate(i, values.size());
  used_ -= lists_[i].size;
  std::copy(values.begin(), values.end(), data_.begin() + lists_[i].begin);
  lists_[i].size = static_cast<Index>(values.size());
  used_ += values.size();
}

void IncidencePool::relocate(std::size_t i, std::size_t capacity) {
  const List old = lists_[i];
  const bool at_end = old.capacity != 0 && std::size_t{old.begin} + old.capacity == data_.size();
  const std::size_t begin = at_end ? old.begin : data_.size();
  check_size(begin + capacity);
  data_.resize(begin + capacity, 0);
  if (!at_end) std::copy_n(data_.begin() + old.begin, old.size, data_.begin() + static_cast<std::ptrdiff_t>(begin));
  lists_[i] = {static_cast<Index>(begin), old.size, static_cast<Index>(capacity)};
}

void IncidencePool::compact_if_sparse() noexcept {
  if (data_.size() < kSmall || data_.size() / 2 <= used_) return;
  RawVector<Index> data;
  try {
    data.reserve(used_ + used_ / 8);
  } catch (const std::bad_alloc&) {
    return;
  }
  for (List& list : lists_) {
    const auto from = data_.begin() + list.begin;
    list.begin = static_cast<Index>(data.size());
    list.capacity = list.size;
    data.insert(data.end(), from, from + list.size);
  }
  data_.swap(data);
}

}  // namespace volccd::detail
