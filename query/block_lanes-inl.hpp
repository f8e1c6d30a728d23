// Common functions of the vector kernels that drop tests of a block: feature filters and narrow phases. Each vector
// lane processes one test. Included once for each instruction set by foreach_target.h of Highway.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include <volccd/numerics/vector_lanes-inl.hpp>
#include <volccd/query/test_block.hpp>

#if defined(VOLCCD_QUERY_BLOCK_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_QUERY_BLOCK_LANES_INL
#undef VOLCCD_QUERY_BLOCK_LANES_INL
#else
#define VOLCCD_QUERY_BLOCK_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Coordinates of consecutive tests in the row order of TestBlock; the distance between rows is kDistance doubles.
template <std::size_t kDistance>
struct Columns {
  const double* rows;
};
using BlockColumns = Columns<TestBlock::kCapacity>;

template <std::size_t kDistance>
HWY_INLINE Lanes3 load(Columns<kDistance> tests, int control_point, int vertex) {
  return load3(Tag(), tests.rows + static_cast<std::size_t>((control_point * 4 + vertex) * 3) * kDistance, kDistance);
}

/// Positions of the vertices 1..3 relative to vertex 0.
template <int kControlPoints>
struct Differences {
  Lanes3 at[3][kControlPoints];
  Lanes3 extent[3];  ///< greatest magnitudes over the control points of the whole step

  template <std::size_t kDistance>
  HWY_INLINE Differences(Columns<kDistance> tests, const StepInterval& interval) {
    const Lanes min = broadcast(kMinExtent);
    for (int v = 0; v < 3; ++v) extent[v] = {min, min, min};
    for (int c = 0; c < kControlPoints; ++c) {
      const Lanes3 origin = load(tests, c, 0);
      for (int v = 0; v < 3; ++v) {
        at[v][c] = sub(load(tests, c, v + 1), origin);
        extent[v] = max(extent[v], abs(at[v][c]));
      }
    }
    for (int v = 0; v < 3; ++v) restrict_to<kControlPoints>(interval, at[v]);
  }
};

/// By how much one feature is beyond the other along an axis at all control points, in the same order: without a
/// rounding bound, and negative if the projections overlap at some control point.
template <FeatureKind kKind>
class Gap {
 public:
  HWY_INLINE Gap() : ahead_(broadcast(std::numeric_limits<double>::infinity())), behind_(ahead_) {}
  /// Projections of the differences 1, 2, 3 at one control point; vertex 0 is the origin.
  HWY_INLINE void include(Lanes p1, Lanes p2, Lanes p3) {
    const Lanes low23 = hn::Min(p2, p3), high23 = hn::Max(p2, p3), zero = hn::Zero(Tag());
    if constexpr (kKind == FeatureKind::vf) {
      ahead_ = hn::Min(hn::Min(p1, low23), ahead_);
      behind_ = hn::Min(hn::Neg(hn::Max(p1, high23)), behind_);
    } else {
      ahead_ = hn::Min(hn::Sub(low23, hn::Max(p1, zero)), ahead_);
      behind_ = hn::Min(hn::Sub(hn::Min(p1, zero), high23), behind_);
    }
  }
  HWY_INLINE Lanes greatest() const { return hn::Max(ahead_, behind_); }

 private:
  Lanes ahead_, behind_;
};

/// The gap along any axis.
template <FeatureKind kKind, int kControlPoints>
HWY_INLINE Lanes gap_along(const Lanes3& axis, const Differences<kControlPoints>& e) {
  Gap<kKind> gap;
  for (int c = 0; c < kControlPoints; ++c)
    gap.include(dot(axis, e.at[0][c]), dot(axis, e.at[1][c]), dot(axis, e.at[2][c]));
  return gap.greatest();
}

/// Bit k: whether test k of 8 is dropped. dropped(tests from k on) returns a mask for one register of tests.
template <std::size_t kDistance, class Dropped>
HWY_INLINE std::uint32_t dropped_bits(Columns<kDistance> tests, Dropped&& dropped) {
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(Tag()))
    bits |= mask_bits(Tag(), dropped(Columns<kDistance>{tests.rows + lane})) << lane;
  return bits;
}

/// Sets keep[i] to 0 for those tests of the block that `dropped` selects. Groups without remaining tests are skipped.
template <class Dropped>
HWY_INLINE void drop_tests(const TestBlock& block, std::span<std::uint8_t> keep, Dropped&& dropped) {
  for (std::size_t i = 0; i < block.size(); i += 8) {
    std::uint64_t flags;
    std::memcpy(&flags, keep.data() + i, 8);
    if (flags == 0) continue;
    // No branches, because the results are hard to predict: byte k is reduced to bit k, then to 1 or 0.
    constexpr std::uint64_t ones = 0x0101010101010101u;
    std::uint64_t spread = (dropped_bits(BlockColumns{block.row(0, 0, 0) + i}, dropped) * ones) & 0x8040201008040201u;
    spread = (((spread + 127 * ones) | spread) >> 7) & ones;
    flags &= ~(spread * 255);
    std::memcpy(keep.data() + i, &flags, 8);
  }
}

/// The same, but first packs the tests with keep[i] != 0 together. For filters that run when few tests remain.
template <class Dropped>
HWY_INLINE void drop_kept_tests(const TestBlock& block, std::span<std::uint8_t> keep, Dropped&& dropped) {
  std::uint8_t kept[TestBlock::kCapacity + 8];
  std::size_t count = 0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    kept[count] = static_cast<std::uint8_t>(i);
    count += keep[i] != 0 ? 1 : 0;
  }
  if (count == 0) return;
  std::fill_n(kept + count, 8, kept[count - 1]);
  alignas(64) double packed[36 * 8];
  const auto rows = static_cast<std::size_t>(block.control_points() * 12);
  for (const std::uint8_t* group = kept; group < kept + count; group += 8) {
    const double* from = block.row(0, 0, 0);
    for (double* to = packed; to < packed + rows * 8; to += 8, from += TestBlock::kCapacity)
      for (std::size_t k = 0; k < 8; ++k) to[k] = from[group[k]];
    const std::uint32_t bits = dropped_bits(Columns<8>{packed}, dropped);
    for (std::size_t k = 0; k < 8; ++k) keep[group[k]] &= static_cast<std::uint8_t>((bits >> k & 1) - 1);
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
