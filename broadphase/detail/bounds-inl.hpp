// Vector operations on rows of a BoundsTable, compiled once for each instruction set (Highway). To be included after
// foreach_target.h.
#if defined(VOLCCD_BROADPHASE_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_BROADPHASE_BOUNDS_INL
#undef VOLCCD_BROADPHASE_BOUNDS_INL
#else
#define VOLCCD_BROADPHASE_BOUNDS_INL
#endif

#include <cstddef>
#include <limits>
#include <span>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <int kWidth>
using RowTag = hn::CappedTag<float, kWidth>;

/// Whether two bounds overlap or touch.
template <int kWidth>
HWY_INLINE bool overlap(const float* a, const float* b) {
  const RowTag<kWidth> d;
  const std::size_t lanes = hn::Lanes(d);
  auto inside =
      hn::And(hn::Le(hn::Load(d, a), hn::Load(d, b + kWidth)), hn::Le(hn::Load(d, b), hn::Load(d, a + kWidth)));
  for (std::size_t i = lanes; i < kWidth; i += lanes) {
    inside = hn::And(inside, hn::Le(hn::Load(d, a + i), hn::Load(d, b + kWidth + i)));
    inside = hn::And(inside, hn::Le(hn::Load(d, b + i), hn::Load(d, a + kWidth + i)));
  }
  return hn::AllTrue(d, inside);
}

template <int kWidth>
HWY_INLINE void make_empty(float* out) {
  const RowTag<kWidth> d;
  for (std::size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    hn::Store(hn::Set(d, std::numeric_limits<float>::infinity()), d, out + i);
    hn::Store(hn::Set(d, -std::numeric_limits<float>::infinity()), d, out + kWidth + i);
  }
}

/// Sets out to the bound of the rows row(0 .. count - 1), count > 0.
template <int kWidth, class Row>
HWY_INLINE void unite_rows(std::size_t count, Row&& row, float* out) {
  const RowTag<kWidth> d;
  for (std::size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const float* const first = row(0) + i;
    auto lo = hn::Load(d, first), hi = hn::Load(d, first + kWidth);
    for (std::size_t r = 1; r < count; ++r) {
      const float* const next = row(r) + i;
      lo = hn::Min(lo, hn::Load(d, next));
      hi = hn::Max(hi, hn::Load(d, next + kWidth));
    }
    hn::Store(lo, d, out + i);
    hn::Store(hi, d, out + kWidth + i);
  }
}

/// The same for the rows of the vertices of an element.
template <int kWidth>
HWY_INLINE void unite_vertices(const float* rows, std::span<const Index> vertices, float* out) {
  unite_rows<kWidth>(
      vertices.size(), [&](std::size_t v) HWY_ATTR { return rows + vertices[v] * std::size_t{2 * kWidth}; }, out);
}

/// Calls f(std::integral_constant<int, width>) for the run-time width 4, 8 or 16.
template <class F>
HWY_INLINE auto with_width(int width, F&& f) {
  if (width == 4) return f(std::integral_constant<int, 4>{});
  if (width == 8) return f(std::integral_constant<int, 8>{});
  return f(std::integral_constant<int, 16>{});
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
