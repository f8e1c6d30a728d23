// Three-dimensional vectors as structures of arrays, for the vector kernels of all modules: each lane holds the
// coordinates of another test, element or vertex. Included once for each instruction set by foreach_target.h of
// Highway.
#include <cstdint>
#include <limits>

#include <volccd/numerics/rounding.hpp>
#include <volccd/numerics/step_interval.hpp>

#if defined(VOLCCD_QUERY_VECTOR_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_QUERY_VECTOR_LANES_INL
#undef VOLCCD_QUERY_VECTOR_LANES_INL
#else
#define VOLCCD_QUERY_VECTOR_LANES_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// For kernels on rows that are padded to a multiple of 8.
using Tag = hn::CappedTag<double, 8>;
using Lanes = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;

template <class V = Lanes>
HWY_INLINE V broadcast(double x) {
  return hn::Set(hn::DFromV<V>(), x);
}

template <class V>
struct LaneVector {
  V x, y, z;
};
using Lanes3 = LaneVector<Lanes>;

/// Loads coordinates from three rows at the given distance from each other. The rows need only the alignment of V.
template <class D>
HWY_INLINE LaneVector<hn::Vec<D>> load3(D d, const hn::TFromD<D>* x, std::size_t distance) {
  return {hn::Load(d, x), hn::Load(d, x + distance), hn::Load(d, x + 2 * distance)};
}
template <class M, class V>
HWY_INLINE LaneVector<V> select(M mask, const LaneVector<V>& yes, const LaneVector<V>& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y), hn::IfThenElse(mask, yes.z, no.z)};
}
/// Bit i: lane i of at most eight.
template <class D>
HWY_INLINE std::uint32_t mask_bits(D d, hn::Mask<D> mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

// Products and sums are written out in a fixed order, on which the rounding bounds rely. Fused multiply-add would make
// results depend on the processor.
template <class V>
HWY_INLINE V add3(V x, V y, V z) {
  return hn::Add(hn::Add(x, y), z);
}
template <class V>
HWY_INLINE LaneVector<V> add(const LaneVector<V>& a, const LaneVector<V>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V>
HWY_INLINE LaneVector<V> sub(const LaneVector<V>& a, const LaneVector<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V>
HWY_INLINE LaneVector<V> scaled(const LaneVector<V>& a, V b) {
  return {hn::Mul(a.x, b), hn::Mul(a.y, b), hn::Mul(a.z, b)};
}
template <class V>
HWY_INLINE V dot(const LaneVector<V>& a, const LaneVector<V>& b) {
  return add3(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z));
}
template <class V>
HWY_INLINE LaneVector<V> cross(const LaneVector<V>& a, const LaneVector<V>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE LaneVector<V> abs(const LaneVector<V>& a) {
  return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)};
}
template <class V>
HWY_INLINE LaneVector<V> max(const LaneVector<V>& a, const LaneVector<V>& b) {
  return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}
/// Sum of absolute values.
template <class V>
HWY_INLINE V norm1(const LaneVector<V>& a) {
  const LaneVector<V> m = abs(a);
  return add3(m.x, m.y, m.z);
}
template <class V>
HWY_INLINE V greatest_coordinate(const LaneVector<V>& a) {
  return hn::Max(hn::Max(a.x, a.y), a.z);
}
/// Greatest magnitudes of the coordinates at both ends, at least kMinExtent.
template <class V>
HWY_INLINE LaneVector<V> extent(const LaneVector<V>& start, const LaneVector<V>& end) {
  const V min = broadcast<V>(kMinExtent);
  return max(max(abs(start), abs(end)), LaneVector<V>{min, min, min});
}
/// x if x < kGreatestMagnitude, otherwise infinity.
template <class V>
HWY_INLINE V trusted(V x) {
  return hn::IfThenElse(hn::Lt(x, broadcast<V>(kGreatestMagnitude)), x,
                        broadcast<V>(std::numeric_limits<double>::infinity()));
}
template <class V>
HWY_INLINE LaneVector<V> trusted(const LaneVector<V>& a) {
  return {trusted(a.x), trusted(a.y), trusted(a.z)};
}
/// An upper bound on the length, except for a rounding error for which kLengthSlack compensates.
template <class V>
HWY_INLINE V length(const LaneVector<V>& a) {
  const V square = dot(a, a);
  return hn::IfThenElse(hn::Gt(square, broadcast<V>(kMinSquare)), hn::Sqrt(square), norm1(a));
}
/// The threshold T of a gap along an axis, for factor = gap_error_factor(n) and trusted extents D.
template <class V>
HWY_INLINE V gap_threshold(const LaneVector<V>& axis, const LaneVector<V>& extent, double factor, double separation) {
  const V sum = trusted(dot(abs(axis), extent));
  const V rounding = hn::Add(hn::Mul(sum, broadcast<V>(factor)), broadcast<V>(kGapUnderflow));
  if (separation == 0) return rounding;
  return hn::Add(rounding, hn::Mul(hn::Mul(length(axis), broadcast<V>(kLengthSlack)), broadcast<V>(separation)));
}

/// Replaces the control points by those of the motion over the part of the step.
template <int kControlPoints, class V>
HWY_INLINE void restrict_to(const StepInterval& interval, LaneVector<V> (&points)[kControlPoints]) {
  for (int level = 1; level <= interval.levels; ++level)
    for (int c = kControlPoints - 1; c >= level; --c)
      points[c] = add(scaled(points[c - 1], broadcast<V>(interval.rest)), scaled(points[c], broadcast<V>(interval.s)));
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
