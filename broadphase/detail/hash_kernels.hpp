// The inner loops of `spatial-hash`, dispatched to the instruction set of the machine.
#pragma once

#include <vector>

#include <volccd/broadphase/detail/hash_grid.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>

namespace volccd::detail {

/// A bucket laid out for vectors: rows of boxes and marks. One for each worker.
class BucketScratch {
 public:
  static constexpr std::size_t kRows = 9, kPadding = 16;

  /// For buckets of up to `entries` entries.
  void reserve(std::size_t entries) {
    stride_ = std::max(stride_, entries + kPadding);
    values_.resize(std::max(values_.size(), kRows * stride_));
    survivors_.resize(std::max(survivors_.size(), stride_));
  }
  float* row(std::size_t i) { return values_.data() + i * stride_; }
  Index* survivors() { return survivors_.data(); }
  std::size_t bytes() const { return values_.capacity() * sizeof(float) + survivors_.capacity() * sizeof(Index); }

 private:
  std::size_t stride_ = 0;
  std::vector<float> values_;
  std::vector<Index> survivors_;
};

/// Writes the wanted pairs (i, j), i < j, of entries of one bucket with i in [begin, end).
void hash_entries(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                  std::size_t begin, std::size_t end, BucketScratch& scratch, PairWriter& out);

/// Writes the wanted pairs of the grid's large elements with the elements at [begin, end).
void hash_large(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                std::size_t begin, std::size_t end, PairWriter& out);

}  // namespace volccd::detail
