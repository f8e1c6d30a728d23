#include <volccd/broadphase/detail/hash_kernels.hpp>

#include <algorithm>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/detail/hash_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <volccd/broadphase/detail/bounds-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

template <int kWidth>
class BucketKernel {
 public:
  BucketKernel(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
               BucketScratch& scratch, PairWriter& out)
      : grid_(grid), bounds_(bounds), slots_(slots), rules_(rules), scratch_(scratch), out_(out) {}

  /// Entries [first, last) of the bucket [begin, end) against all behind them in it.
  void run(std::size_t begin, std::size_t end, std::size_t first, std::size_t last) {
    load(begin, end);
    for (std::size_t i = first - begin; i < last - begin; ++i) offer(begin, i, survivors(i, end - begin));
  }

 private:
  using Lanes = hn::CappedTag<float, 8>;
  using Marks = hn::Rebind<std::int32_t, Lanes>;

  /// Rows 0 to 5: the box; 6: a bit for each axis along which this is the element's lowest cell; 7: a number that entries of
  /// the same cell share; 8: the position.
  void load(std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    std::int32_t* const lowest = reinterpret_cast<std::int32_t*>(scratch_.row(6));
    std::int32_t* const cell = reinterpret_cast<std::int32_t*>(scratch_.row(7));
    Index* const position = reinterpret_cast<Index*>(scratch_.row(8));
    for (std::size_t i = 0; i < count; ++i) {
      const HashEntry entry = grid_.entries()[begin + i];
      const float* const row = bounds_.row(entry.position);
      for (std::size_t c = 0; c < 3; ++c) {
        scratch_.row(c)[i] = row[c];
        scratch_.row(3 + c)[i] = row[kWidth + c];
      }
      const Index x = entry.offset & 1023, y = entry.offset >> 10 & 1023, z = entry.offset >> 20;
      lowest[i] = (x == 0 ? 1 : 0) | (y == 0 ? 2 : 0) | (z == 0 ? 4 : 0);
      position[i] = entry.position;
      cell[i] = static_cast<std::int32_t>(i);
      for (std::size_t j = 0; j < i; ++j)
        if (cell[j] == static_cast<std::int32_t>(j) && same_cell(grid_.entries()[begin + j], entry)) {
          cell[i] = static_cast<std::int32_t>(j);
          break;
        }
    }
    for (std::size_t i = count; i < count + BucketScratch::kPadding; ++i) {
      for (std::size_t c = 0; c < 6; ++c) scratch_.row(c)[i] = c < 3 ? 1.0f : -1.0f;
      lowest[i] = cell[i] = 0;
    }
  }

  bool same_cell(const HashEntry& a, const HashEntry& b) const {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t in_a = static_cast<std::int32_t>(a.offset >> (10 * c) & 1023);
      const std::int32_t in_b = static_cast<std::int32_t>(b.offset >> (10 * c) & 1023);
      if (grid_.cells()[a.position].low[c] + in_a != grid_.cells()[b.position].low[c] + in_b) return false;
    }
    return true;
  }

  /// Entries j > i of i's cell whose box overlaps i's, where this cell holds the lower corner of the intersection: along
  /// each axis it is the lowest of one of the two. Returns their number.
  HWY_INLINE std::size_t survivors(std::size_t i, std::size_t count) {
    const Lanes d;
    const Marks di;
    const hn::Rebind<std::uint32_t, Lanes> du;
    const std::int32_t* const lowest = reinterpret_cast<const std::int32_t*>(scratch_.row(6));
    const std::int32_t* const cell = reinterpret_cast<const std::int32_t*>(scratch_.row(7));
    const auto lowest_i = hn::Set(di, lowest[i]), cell_i = hn::Set(di, cell[i]), all = hn::Set(di, 7);
    std::size_t found = 0;
    for (std::size_t j = i + 1; j < count; j += hn::Lanes(d)) {
      auto keep = hn::Eq(hn::Or(lowest_i, hn::LoadU(di, lowest + j)), all);
      keep = hn::And(keep, hn::Eq(cell_i, hn::LoadU(di, cell + j)));
      auto inside = hn::RebindMask(d, keep);
      for (std::size_t c = 0; c < 3; ++c) {
        inside = hn::And(inside, hn::Le(hn::Set(d, scratch_.row(c)[i]), hn::LoadU(d, scratch_.row(3 + c) + j)));
        inside = hn::And(inside, hn::Le(hn::LoadU(d, scratch_.row(c) + j), hn::Set(d, scratch_.row(3 + c)[i])));
      }
      const auto index = hn::Iota(du, static_cast<std::uint32_t>(j));
      found += hn::CompressStore(index, hn::RebindMask(du, inside), du, scratch_.survivors() + found);
    }
    return found;
  }

  HWY_INLINE void offer(std::size_t, std::size_t i, std::size_t count) {
    const Index* const position = reinterpret_cast<const Index*>(scratch_.row(8));
    const Index* const list = scratch_.survivors();
    const float* const row = bounds_.row(position[i]);
    const Index a = slots_[position[i]];
    for (std::size_t done = 0; done < count; done += PairWriter::kRoom) {
      ElementPair* next = out_.room();
      for (std::size_t s = done; s < std::min(count, done + PairWriter::kRoom); ++s) {
        const Index p = position[list[s]], b = slots_[p];
        *next = {std::min(a, b), std::max(a, b)};
        next += overlap<kWidth>(row, bounds_.row(p)) & rules_.want(a, b);
      }
      out_.written(next);
    }
  }

  const HashGrid& grid_;
  const BoundsTable& bounds_;
  const Index* const slots_;
  const PairRules rules_;
  BucketScratch& scratch_;
  PairWriter& out_;
};

void entries_kernel(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                    std::size_t begin, std::size_t end, BucketScratch& scratch, PairWriter& out) {
  with_width(bounds.width(), [&](auto width) {
    BucketKernel<width> kernel(grid, bounds, slots, rules, scratch, out);
    const std::vector<Index>& begins = grid.begins();
    // The bucket that holds entry `begin`: the last one that begins at or before it.
    std::size_t bucket =
        static_cast<std::size_t>(std::upper_bound(begins.begin(), begins.end(), begin) - begins.begin()) - 1;
    for (; bucket < grid.buckets() && begins[bucket] < end; ++bucket) {
      const std::size_t first = std::max<std::size_t>(begin, begins[bucket]), stop = begins[bucket + 1];
      if (stop - begins[bucket] > 1) kernel.run(begins[bucket], stop, first, std::min(end, stop));
    }
  });
}

void large_kernel(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                  std::size_t begin, std::size_t end, PairWriter& out) {
  with_width(bounds.width(), [&](auto width) {
    for (const Index large : grid.large())
      for (std::size_t done = begin; done < end; done += PairWriter::kRoom) {
        ElementPair* next = out.room();
        for (std::size_t p = done; p < std::min(end, done + PairWriter::kRoom); ++p) {
          const Index a = slots[large], b = slots[p];
          *next = {std::min(a, b), std::max(a, b)};
          const bool once = !grid.is_large(p) || p > large;
          next += once && overlap<width>(bounds.row(large), bounds.row(p)) && rules.want(a, b);
        }
        out.written(next);
      }
  });
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(entries_kernel);
HWY_EXPORT(large_kernel);

void hash_entries(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                  std::size_t begin, std::size_t end, BucketScratch& scratch, PairWriter& out) {
  HWY_DYNAMIC_DISPATCH(entries_kernel)(grid, bounds, slots, rules, begin, end, scratch, out);
}

void hash_large(const HashGrid& grid, const BoundsTable& bounds, const Index* slots, const PairRules& rules,
                std::size_t begin, std::size_t end, PairWriter& out) {
  HWY_DYNAMIC_DISPATCH(large_kernel)(grid, bounds, slots, rules, begin, end, out);
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
