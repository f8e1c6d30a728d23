#include <volccd/mesh/detail/incidence_pool.hpp>

#include <algorithm>
#include <cassert>

#include <volccd/core/error.hpp>

namespace volccd::detail {

namespace {

/// Spare room at the end of the array, so that the first changes after a build do not copy all of it.
std::size_t with_spare(std::size_t entries) { return entries + entries / 8; }

void check_size(std::size_t entries) {
  if (entries >= kNone) throw Error("mesh too large: more than 2^32 incidences of features and elements");
}

constexpr std::size_t kSmall = 1024;  // arrays below this are not worth compacting

}  // namespace

void IncidencePool::layout(std::span<const Index> lengths) {
  std::size_t total = 0;
  for (Index length : lengths) total += length;
  clear(lengths.size(), total);
  data_.resize(total);
  Index begin = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    lists_[i] = {begin, 0, lengths[i]};
    begin += lengths[i];
  }
}

void IncidencePool::clear(std::size_t lists, std::size_t entries) {
  check_size(entries);
  *this = IncidencePool();
  lists_.resize(lists);
  data_.reserve(with_spare(entries));
}

void IncidencePool::insert(std::size_t i, Index value) {
  if (lists_[i].size == lists_[i].capacity) grow(i);
  Index* const first = data_.data() + lists_[i].begin;
  Index* const last = first + lists_[i].size;
  Index* const at = std::lower_bound(first, last, value);
  assert(at == last || *at != value);
  std::copy_backward(at, last, last + 1);
  *at = value;
  ++lists_[i].size;
  ++used_;
}

void IncidencePool::erase(std::size_t i, Index value) {
  Index* const first = data_.data() + lists_[i].begin;
  Index* const last = first + lists_[i].size;
  Index* const at = std::lower_bound(first, last, value);
  assert(at != last && *at == value);
  std::copy(at + 1, last, at);
  --lists_[i].size;
  --used_;
  compact_if_sparse();
}

void IncidencePool::assign(std::size_t i, std::span<const Index> values) {
  clear_list(i);
  if (lists_[i].capacity < values.size()) relocate(i, values.size());
  std::copy(values.begin(), values.end(), data_.begin() + lists_[i].begin);
  lists_[i].size = static_cast<Index>(values.size());
  used_ += values.size();
}

void IncidencePool::clear_list(std::size_t i) {
  used_ -= lists_[i].size;
  lists_[i].size = 0;
  compact_if_sparse();
}

void IncidencePool::relocate(std::size_t i, std::size_t capacity) {
  compact_if_sparse();
  const List old = lists_[i];
  const bool at_end = old.capacity != 0 && std::size_t{old.begin} + old.capacity == data_.size();
  const std::size_t begin = at_end ? old.begin : data_.size();
  check_size(begin + capacity);
  data_.resize(begin + capacity);
  if (!at_end) std::copy_n(data_.begin() + old.begin, old.size, data_.begin() + static_cast<std::ptrdiff_t>(begin));
  lists_[i] = {static_cast<Index>(begin), old.size, static_cast<Index>(capacity)};
}

void IncidencePool::compact_if_sparse() {
  if (data_.size() < kSmall || data_.size() / 2 <= used_) return;
  std::vector<Index> data;
  data.reserve(with_spare(used_));
  for (List& list : lists_) {
    const auto from = data_.begin() + list.begin;
    list.begin = static_cast<Index>(data.size());
    list.capacity = list.size;
    data.insert(data.end(), from, from + list.size);
  }
  data_.swap(data);
}

}  // namespace volccd::detail
