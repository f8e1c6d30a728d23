// The hashed grid of `spatial-hash`: which elements enter which cells, in buckets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/executor.hpp>

namespace volccd::detail {

/// An element in one of its cells. `offset` counts cells from the element's lowest one: 10 bits an axis.
struct HashEntry {
  Index position, offset;
};

/// Cells that an element's box overlaps: from `low`, `count` along each axis.
struct CellRange {
  std::array<std::int32_t, 3> low, count;
};

class HashGrid {
 public:
  /// For boxes (axes 0 to 2 of the bounds) of `elements` rows. Elements that would enter more than `most_cells` cells
  /// are large() instead: at most one in 200.
  void build(const BoundsTable& bounds, std::size_t elements, double cell_size, std::int64_t most_cells,
             Executor& executor);

  /// Bucket b holds entries [begins()[b], begins()[b + 1]). Their order within it is arbitrary.
  std::size_t buckets() const { return mask_ + 1; }
  const std::vector<Index>& begins() const { return begins_; }
  const std::vector<HashEntry>& entries() const { return entries_; }
  const std::vector<CellRange>& cells() const { return cells_; }
  std::size_t largest_bucket() const { return largest_bucket_; }

  /// Positions, ascending, and a flag for each element.
  const std::vector<Index>& large() const { return large_; }
  bool is_large(std::size_t position) const { return cells_[position].count[0] == 0; }

  std::size_t bytes() const;

 private:
  void choose_cell(const BoundsTable& bounds, std::size_t elements, double cell_size, Executor& executor);
  void find_cells(const BoundsTable& bounds, std::size_t elements, std::int64_t most_cells, Executor& executor);
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
