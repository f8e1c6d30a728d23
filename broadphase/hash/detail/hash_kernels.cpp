#include <volccd/broadphase/hash/detail/hash_kernels.hpp>

#include <algorithm>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/hash/detail/hash_kernels.cpp"
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

  /// Tests the entries [first, last) of the bucket [begin, end) against all entries that follow them in it.
  void run(std::size_t begin, std::size_t end, std::size_t first, std::size_t last) {
    load(begin, end);
    for (std::size_t i = first - begin; i < last - begin; ++i) offer(i, survivors(i, end - begin));
  }

 private:
  using Lanes = hn::CappedTag<float, 8>;

  /// Marks 0: a bit for each axis along which this is the lowest cell of the element; 1: a number that is the same for
  /// entries of the same cell; 2: the position.
  void load(std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    for (std::size_t i = 0; i < count; ++i) {
      const HashEntry entry = grid_.entries()[begin + i];
      const float* const row = bounds_.row(entry.position);
      for (std::size_t c = 0; c < 2 * kWidth; ++c) scratch_.row(c)[i] = row[c];
      const Index x = entry.offset & 1023, y = entry.offset >> 10 & 1023, z = entry.offset >> 20;
      scratch_.marks(0)[i] = (x == 0 ? 1 : 0) | (y == 0 ? 2 : 0) | (z == 0 ? 4 : 0);
      scratch_.marks(1)[i] = cell_number(begin, i);
      scratch_.marks(2)[i] = static_cast<std::int32_t>(entry.position);
    }
    for (std::size_t i = count; i < count + BucketScratch::kPadding; ++i) {
      scratch_.row(0)[i] = std::numeric_limits<float>::infinity();
      scratch_.marks(0)[i] = scratch_.marks(1)[i] = 0;
    }
  }

  /// The first entry of the bucket in the same cell as entry i.
  std::int32_t cell_number(std::size_t begin, std::size_t i) {
    const std::int32_t* const cell = scratch_.marks(1);
    for (std::size_t j = 0; j < i; ++j)
      if (cell[j] == static_cast<std::int32_t>(j) && same_cell(grid_.entries()[begin + j], grid_.entries()[begin + i]))
        return cell[j];
    return static_cast<std::int32_t>(i);
  }

  bool same_cell(const HashEntry& a, const HashEntry& b) const {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t in_a = static_cast<std::int32_t>(a.offset >> (10 * c) & 1023);
      const std::int32_t in_b = static_cast<std::int32_t>(b.offset >> (10 * c) & 1023);
      if (grid_.cells()[a.position].low[c] + in_a != grid_.cells()[b.position].low[c] + in_b) return false;
    }
    return true;
  }

  /// Finds the entries j > i of the cell of entry i whose bounds overlap those of i, if this cell contains the lower
  /// corner of the intersection of the boxes: along each axis it is the lowest cell of one of the two. Returns their
  /// number.
  HWY_INLINE std::size_t survivors(std::size_t i, std::size_t count) {
    const Lanes d;
    const hn::Rebind<std::int32_t, Lanes> di;
    const hn::Rebind<std::uint32_t, Lanes> du;
    const std::int32_t* const lowest = scratch_.marks(0);
    const std::int32_t* const cell = scratch_.marks(1);
    const auto lowest_i = hn::Set(di, lowest[i]), cell_i = hn::Set(di, cell[i]), all = hn::Set(di, 7);
    std::size_t found = 0;
    for (std::size_t j = i + 1; j < count; j += hn::Lanes(d)) {
      auto keep = hn::Eq(hn::Or(lowest_i, hn::LoadU(di, lowest + j)), all);
      keep = hn::And(keep, hn::Eq(cell_i, hn::LoadU(di, cell + j)));
      auto inside = hn::RebindMask(d, keep);
      const auto narrow = [&](std::size_t axis) HWY_ATTR {
        const float *low = scratch_.row(axis), *high = scratch_.row(kWidth + axis);
        inside = hn::And(inside, hn::Le(hn::Set(d, low[i]), hn::LoadU(d, high + j)));
        inside = hn::And(inside, hn::Le(hn::LoadU(d, low + j), hn::Set(d, high[i])));
      };
      for (std::size_t axis = 0; axis < 3; ++axis) narrow(axis);
      if (hn::AllFalse(d, inside)) continue;
      for (std::size_t axis = 3; axis < kWidth; ++axis) narrow(axis);
      const auto survives = hn::RebindMask(du, inside);
      // CompressStore() instead would be slow on AMD's Zen 4.
      hn::StoreU(hn::Compress(hn::Iota(du, static_cast<std::uint32_t>(j)), survives), du, scratch_.survivors() + found);
      found += hn::CountTrue(du, survives);
    }
    return found;
  }

  HWY_INLINE void offer(std::size_t i, std::size_t count) {
    const std::int32_t* const position = scratch_.marks(2);
    const Index* const list = scratch_.survivors();
    const Index a = slots_[position[i]];
    for (std::size_t done = 0; done < count; done += PairWriter::kRoom) {
      ElementPair* next = out_.room();
      for (std::size_t s = done; s < std::min(count, done + PairWriter::kRoom); ++s) {
        const Index b = slots_[position[list[s]]];
        *next = ordered(a, b);
        next += rules_.included(a, b);
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
    // The bucket that contains entry `begin`: the last one that begins at or before it.
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
          *next = ordered(a, b);
          const bool once = !grid.is_large(p) || p > large;
          next += once && overlap<width>(bounds.row(large), bounds.row(p)) && rules.included(a, b);
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
