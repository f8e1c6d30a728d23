// The hashed grid of `spatial-hash`: assigns elements to cells, and cells to buckets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>

namespace volccd::detail {

/// An element in one of its cells. `offset` is the position of the cell relative to the element's lowest cell, with 10
/// bits per axis.
struct HashEntry {
  Index position, offset;
};

/// The cells that the box of an element overlaps: `count` cells along each axis, beginning at `low`.
struct CellRange {
  std::array<std::int32_t, 3> low, count;
};

class HashGrid {
 public:
  /// Builds the grid for `elements` boxes (axes 0 to 2 of the bounds). Elements that would be entered in more than
  /// `max_cells` cells are listed in large() instead, at most one in 200.
  void build(const BoundsTable& bounds, std::size_t elements, double cell_size, std::int64_t max_cells,
             Executor& executor);

  /// Bucket b contains the entries [begins()[b], begins()[b + 1]) in arbitrary order.
  std::size_t buckets() const { return mask_ + 1; }
  const std::vector<Index>& begins() const { return begins_; }
  const std::vector<HashEntry>& entries() const { return entries_; }
  const std::vector<CellRange>& cells() const { return cells_; }
  std::size_t largest_bucket() const { return largest_bucket_; }

  /// Positions of large elements, ascending, and whether an element is large.
  const std::vector<Index>& large() const { return large_; }
  bool is_large(std::size_t position) const { return cells_[position].count[0] == 0; }

  std::size_t bytes() const { return heap_bytes(cells_, extents_, begins_, large_, entries_); }

 private:
  void choose_cell(const BoundsTable& bounds, std::size_t elements, double cell_size, Executor& executor);
  void find_cells(const BoundsTable& bounds, std::size_t elements, std::int64_t max_cells, Executor& executor);
  template <class Visit>
  void visit_cells(std::size_t position, Visit&& visit) const;

  double inverse_cell_ = 1;
  std::size_t mask_ = 0, largest_bucket_ = 0;
  std::vector<CellRange> cells_;
  std::vector<double> extents_;
  std::vector<Index> begins_, large_;
  std::vector<HashEntry> entries_;
};

}  // namespace volccd::detail
