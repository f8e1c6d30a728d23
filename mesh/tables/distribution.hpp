// Distribution of records to ranges of keys, in parallel.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/tables/chunks.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>

namespace volccd::detail {

/// Records in the order of ranges of keys. Within a range they are in the order of their items, so that the result does
/// not depend on the number of threads. The ranges are small enough that a thread can sort one of them in its cache.
template <class Record>
class Distribution {
 public:
  /// Record::key() is less than `keys`, which is at most 2^32. visit(chunk, begin, end, add) calls add(record) for each
  /// record of the items [begin, end), which are a chunk of Chunks(items). It is called twice for each chunk, in
  /// parallel, with the same records. About `expected` records; the number determines the number of ranges.
  template <class Visit>
  Distribution(std::size_t items, std::uint64_t keys, std::size_t expected, Executor& executor, Visit&& visit)
      : keys_(keys) {
    const std::size_t max = std::clamp<std::size_t>(expected / kRecords, 1, kMaxRanges);
    while (keys > std::uint64_t{max} << shift_) ++shift_;
    const std::size_t ranges = static_cast<std::size_t>((keys + (std::uint64_t{1} << shift_) - 1) >> shift_);
    const Chunks chunks(items);
    std::vector<std::size_t> next(chunks.count() * ranges);  // position of the next record, by chunk and range
    chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
      std::size_t* const counts = next.data() + c * ranges;
      visit(c, begin, end, [&](const Record& record) { ++counts[range_of(record)]; });
    });
    begin_.resize(ranges + 1);
    for (std::size_t r = 0, position = 0; r < ranges; ++r) {
      for (std::size_t c = 0; c < chunks.count(); ++c) position += std::exchange(next[c * ranges + r], position);
      begin_[r + 1] = position;
    }
    records_.resize(begin_.back());
    chunks.for_each(executor, [&](std::size_t c, std::size_t begin, std::size_t end) {
      std::size_t* const positions = next.data() + c * ranges;
      visit(c, begin, end, [&](const Record& record) { records_[positions[range_of(record)]++] = record; });
    });
  }

  std::size_t size() const { return records_.size(); }
  std::size_t ranges() const { return begin_.size() - 1; }
  /// The records of range r, those of all ranges before it, and its first key; the keys of range r are less than the
  /// first key of range r + 1.
  std::span<Record> operator[](std::size_t r) { return {records_.data() + begin_[r], begin_[r + 1] - begin_[r]}; }
  std::size_t begin(std::size_t r) const { return begin_[r]; }
  std::uint64_t first_key(std::size_t r) const { return std::min(keys_, std::uint64_t{r} << shift_); }

  /// Calls body(r, worker) for each range, in parallel.
  template <class Body>
  void for_each_range(Executor& executor, Body&& body) const {
    executor.parallel_for(ranges(), 1, [&](std::size_t first, std::size_t last, unsigned worker) {
      for (std::size_t r = first; r < last; ++r) body(r, worker);
    });
  }

 private:
  static constexpr std::size_t kRecords = 8192, kMaxRanges = 1024;

  std::size_t range_of(const Record& record) const {
    return static_cast<std::size_t>(std::uint64_t{record.key()} >> shift_);
  }

  std::uint64_t keys_;
  unsigned shift_ = 0;
  RawVector<Record> records_;
  std::vector<std::size_t> begin_;  ///< [ranges() + 1]
};

}  // namespace volccd::detail
