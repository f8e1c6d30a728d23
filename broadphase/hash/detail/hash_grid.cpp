#include <volccd/broadphase/hash/detail/hash_grid.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include <volccd/core/error.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kGrain = 2048;
/// Only elements beyond this quantile of extents may be large; the cell size is such that the others never are.
constexpr double kLargeQuantile = 0.995;
/// A box with an extent of this many cells overlaps at most six cells per axis, 216 in total, which is less than
/// SpatialHash::kMaxCells.
constexpr double kMaxExtent = 5;
/// Cell coordinates are clamped to this magnitude, so that they and their differences fit in 32 bits.
constexpr double kFarthest = 1 << 30;

/// Multiplies a coordinate of a cell by one of the three primes of Teschner et al.
std::uint32_t hash_part(std::size_t axis, std::int32_t cell) {
  constexpr std::uint32_t primes[3] = {73856093u, 19349663u, 83492791u};
  return static_cast<std::uint32_t>(cell) * primes[axis];
}

}  // namespace

/// Calls visit(bucket, offset) for each cell of the element.
template <class Visit>
void HashGrid::visit_cells(std::size_t position, Visit&& visit) const {
  const CellRange& range = cells_[position];
  for (std::int32_t z = 0; z < range.count[2]; ++z)
    for (std::int32_t y = 0; y < range.count[1]; ++y) {
      const std::uint32_t zy = hash_part(2, range.low[2] + z) ^ hash_part(1, range.low[1] + y);
      for (std::int32_t x = 0; x < range.count[0]; ++x)
        visit((zy ^ hash_part(0, range.low[0] + x)) & mask_, static_cast<Index>(x | y << 10 | z << 20));
    }
}

void HashGrid::build(const BoundsTable& bounds, std::size_t elements, double cell_size, std::int64_t max_cells,
                     Executor& executor) {
  choose_cell(bounds, elements, cell_size, executor);
  find_cells(bounds, elements, max_cells, executor);

  // Counting sort by bucket. The prefix sums are first the ends of the buckets; filling each bucket from its end turns
  // them into the beginnings.
  mask_ = std::bit_ceil(std::max<std::size_t>(elements, 16)) - 1;
  begins_.assign(buckets() + 1, 0);
  const auto for_all = [&](auto&& visit) {
    executor.parallel_for(elements, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t p = begin; p < end; ++p)
        visit_cells(p, [&](std::size_t bucket, Index offset) { visit(p, bucket, offset); });
    });
  };
  const bool alone = executor.workers() == 1;
  for_all([&](std::size_t, std::size_t bucket, Index) {
    if (alone)
      ++begins_[bucket];
    else
      std::atomic_ref(begins_[bucket]).fetch_add(1, std::memory_order_relaxed);
  });
  Index total = 0;
  largest_bucket_ = 0;
  for (Index& entry : begins_) {
    largest_bucket_ = std::max<std::size_t>(largest_bucket_, entry);
    entry = total += entry;
  }
  entries_.resize(total);
  for_all([&](std::size_t p, std::size_t bucket, Index offset) {
    const Index at =
        alone ? --begins_[bucket] : std::atomic_ref(begins_[bucket]).fetch_sub(1, std::memory_order_relaxed) - 1;
    entries_[at] = {static_cast<Index>(p), offset};
  });
}

void HashGrid::choose_cell(const BoundsTable& bounds, std::size_t elements, double cell_size, Executor& executor) {
  if (elements == 0) return;
  const auto width = static_cast<std::size_t>(bounds.width());
  extents_.resize(elements);
  executor.parallel_for(elements, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t p = begin; p < end; ++p) {
      const float* const row = bounds.row(p);
      double extent = 0;
      for (std::size_t c = 0; c < 3; ++c)
        extent = std::max(extent, static_cast<double>(row[width + c]) - static_cast<double>(row[c]));
      extents_[p] = extent;
    }
  });
  const auto median = extents_.begin() + static_cast<std::ptrdiff_t>(elements / 2);
  std::nth_element(extents_.begin(), median, extents_.end());
  const auto last = static_cast<std::ptrdiff_t>(static_cast<double>(elements - 1) * kLargeQuantile);
  const auto large = std::max(median, extents_.begin() + last);
  std::nth_element(median, large, extents_.end());
  double cell = std::max(*median * cell_size, *large / kMaxExtent);
  if (!(cell > 0)) cell = 1;  // all boxes are points, for which any grid is suitable
  inverse_cell_ = 1 / cell;
}

void HashGrid::find_cells(const BoundsTable& bounds, std::size_t elements, std::int64_t max_cells, Executor& executor) {
  const auto width = static_cast<std::size_t>(bounds.width());
  cells_.resize(elements);
  // floor, multiplication and clamping are monotone; therefore the cell of the greater lower end of two overlapping
  // intervals is a cell of both.
  const auto cell_of = [&](float x) {
    const double at = std::floor(static_cast<double>(x) * inverse_cell_);
    return static_cast<std::int32_t>(std::clamp(at, -kFarthest, kFarthest));
  };
  executor.parallel_for(elements, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t p = begin; p < end; ++p) {
      const float* const row = bounds.row(p);
      CellRange& range = cells_[p];
      std::int64_t cells = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        range.low[c] = cell_of(row[c]);
        const std::int64_t count = std::int64_t{cell_of(row[width + c])} - range.low[c] + 1;
        range.count[c] = static_cast<std::int32_t>(std::min(count, max_cells + 1));
        cells = std::min(cells, max_cells + 1) * range.count[c];
      }
      if (cells > max_cells) range.count = {0, 0, 0};
    }
  });
  large_.clear();
  std::uint64_t entries = 0;
  for (std::size_t p = 0; p < elements; ++p) {
    const auto& count = cells_[p].count;
    entries += static_cast<std::uint64_t>(count[0]) * static_cast<std::uint64_t>(count[1] * count[2]);
    if (is_large(p)) large_.push_back(static_cast<Index>(p));
  }
  if (entries >= kNone) throw Error("spatial-hash: more cells entered than can be counted; take a larger cell_size");
}

}  // namespace volccd::detail
