// What the feature filters share: a test a lane. Included once for each instruction set, inside foreach_target sources.
#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/query/test_block.hpp>
#include <volccd/query/vector_lanes-inl.hpp>

#if defined(VOLCCD_FILTER_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_FILTER_LANES_INL
#undef VOLCCD_FILTER_LANES_INL
#else
#define VOLCCD_FILTER_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

HWY_INLINE Lanes3 load(const TestBlock& block, int control_point, int vertex, std::size_t i) {
  return load3(Tag(), block.row(control_point, vertex, 0) + i, TestBlock::kCapacity);
}

/// Vertices 1..3 relative to vertex 0.
template <int kControlPoints>
struct Differences {
  Lanes3 at[3][kControlPoints];
  Lanes3 extent[3];  ///< greatest magnitudes over the control points of the whole step; infinite where not trusted

  HWY_INLINE Differences(const TestBlock& block, const StepPart& part, std::size_t i) {
    const Lanes least = broadcast(kLeastExtent);
    for (int v = 0; v < 3; ++v) extent[v] = {least, least, least};
    for (int c = 0; c < kControlPoints; ++c) {
      const Lanes3 origin = load(block, c, 0, i);
      for (int v = 0; v < 3; ++v) {
        at[v][c] = sub(load(block, c, v + 1, i), origin);
        extent[v] = max(extent[v], abs(at[v][c]));
      }
    }
    for (int v = 0; v < 3; ++v) {
      extent[v] = {trusted(extent[v].x), trusted(extent[v].y), trusted(extent[v].z)};
      restrict_to<kControlPoints>(part, at[v]);
    }
  }
};

HWY_INLINE void drop(LaneMask mask, std::size_t i, std::span<std::uint8_t> keep) {
  const Tag tag;
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(tag, mask, bits);
  for (std::size_t lane = 0; lane < hn::Lanes(tag); ++lane)  // without a branch: masks are hard to predict
    keep[i + lane] &= static_cast<std::uint8_t>((bits[0] >> lane & 1) - 1);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
