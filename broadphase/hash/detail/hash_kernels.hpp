// The inner loops of `spatial-hash`, selected at run time for the instruction set of the processor.
#pragma once

#include <algorithm>
#include <vector>

#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/broadphase/hash/detail/hash_grid.hpp>
#include <volccd/core/heap_bytes.hpp>

namespace volccd::detail {

/// A bucket in a layout for vector instructions: rows of bounds and marks. Each worker has one.
class BucketScratch {
 public:
  static constexpr std::size_t kPadding = 8;

  /// Reserves memory for buckets of up to `entries` entries.
  void reserve(std::size_t entries) {
    stride_ = std::max(stride_, entries + kPadding);
    values_.resize(BoundsTable::kMaxFloats * stride_);
    marks_.resize(3 * stride_);
    survivors_.resize(stride_);
  }
  /// Row i for all entries: minima, then maxima, in the order of a row of a BoundsTable.
  float* row(std::size_t i) { return values_.data() + i * stride_; }
  std::int32_t* marks(std::size_t i) { return marks_.data() + i * stride_; }
  Index* survivors() { return survivors_.data(); }
  std::size_t bytes() const { return heap_bytes(values_, marks_, survivors_); }

 private:
  std::size_t stride_ = 0;
  std::vector<float> values_;
  std::vector<std::int32_t> marks_;
  std::vector<Index> survivors_;
};

/// Writes the requested pairs (i, j), i < j, of entries in the same bucket, with i in [begin, end).
void hash_entries(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                  std::size_t begin, std::size_t end, BucketScratch& scratch, PairWriter& out);

/// Writes the requested pairs of large elements of the grid with the elements at positions [begin, end).
void hash_large(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                std::size_t begin, std::size_t end, PairWriter& out);

}  // namespace volccd::detail
