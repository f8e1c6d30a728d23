#include <volccd/broadphase/bvh/detail/build_kernels.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/bvh/detail/build_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using HalfTag = hn::CappedTag<float, 4>;

HWY_INLINE void add_box(const float* ends, float* box) {
  const hn::CappedTag<float, 8> d;
  for (std::size_t c = 0; c < 8; c += hn::Lanes(d))
    hn::StoreU(hn::Min(hn::LoadU(d, box + c), hn::LoadU(d, ends + c)), d, box + c);
}

void make_items_kernel(const ElementList& list, const BoundsTable& vertices, Index begin, Index end,
                       const BuildBox& gap, BuildItem* out) {
  const HalfTag d;
  const std::size_t width = static_cast<std::size_t>(vertices.width());
  for (Index p = begin; p < end; ++p, ++out) {
    *out = {gap, p};
    if (list.slot(p) == kNone) continue;
    const std::span<const Index> own = list.vertices(p);
    for (std::size_t c = 0; c < 4; c += hn::Lanes(d)) {
      auto low = hn::LoadU(d, vertices.row(own[0]) + c), high = hn::LoadU(d, vertices.row(own[0]) + width + c);
      for (const Index v : own.subspan(1)) {
        low = hn::Min(low, hn::LoadU(d, vertices.row(v) + c));
        high = hn::Max(high, hn::LoadU(d, vertices.row(v) + width + c));
      }
      hn::StoreU(low, d, out->box.ends.data() + c);
      hn::StoreU(hn::Neg(high), d, out->box.ends.data() + 4 + c);
    }
  }
}

void range_of_keys_kernel(std::span<const BuildItem> items, BuildBox& range) {
  const HalfTag d;
  for (std::size_t c = 0; c < 4; c += hn::Lanes(d)) {
    auto low = hn::Set(d, std::numeric_limits<float>::infinity()), high = hn::Neg(low);
    for (const BuildItem& item : items) {
      const float* const ends = item.box.ends.data() + c;
      const auto key = hn::Sub(hn::LoadU(d, ends), hn::LoadU(d, ends + 4));
      low = hn::Min(low, key);
      high = hn::Max(high, key);
    }
    hn::StoreU(low, d, range.ends.data() + c);
    hn::StoreU(hn::Neg(high), d, range.ends.data() + 4 + c);
  }
}

void fill_bins_kernel(std::span<const BuildItem> items, const BuildBins& bins, BuildBins::Contents& contents) {
  const HalfTag d;
  const hn::RebindToSigned<HalfTag> di;
  for (auto& axis : contents) axis.fill({BuildBox::empty(), 0});
  for (const BuildItem& item : items) {
    const float* const ends = item.box.ends.data();
    std::int32_t at[4];
    for (std::size_t c = 0; c < 4; c += hn::Lanes(d)) {
      const auto key = hn::Sub(hn::LoadU(d, ends + c), hn::LoadU(d, ends + 4 + c));
      const auto place =
          hn::Mul(hn::Sub(key, hn::LoadU(d, bins.first.data() + c)), hn::LoadU(d, bins.scale.data() + c));
      hn::StoreU(hn::ConvertTo(di, hn::Min(place, hn::Set(d, BuildBins::kCount - 1.0f))), di, at + c);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      BuildBins::Bin& bin = contents[axis][static_cast<std::size_t>(at[axis])];
      add_box(ends, bin.box.ends.data());
      ++bin.count;
    }
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(make_items_kernel);
HWY_EXPORT(range_of_keys_kernel);
HWY_EXPORT(fill_bins_kernel);

void make_items(const ElementList& list, const BoundsTable& vertices, Index begin, Index end, const BuildBox& gap,
                BuildItem* out) {
  HWY_DYNAMIC_DISPATCH(make_items_kernel)(list, vertices, begin, end, gap, out);
}

BuildBox range_of_keys(std::span<const BuildItem> items) {
  BuildBox range;
  HWY_DYNAMIC_DISPATCH(range_of_keys_kernel)(items, range);
  return range;
}

void fill_bins(std::span<const BuildItem> items, const BuildBins& bins, BuildBins::Contents& contents) {
  HWY_DYNAMIC_DISPATCH(fill_bins_kernel)(items, bins, contents);
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
