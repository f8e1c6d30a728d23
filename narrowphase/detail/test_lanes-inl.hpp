// What the vector kernels of the narrow phases share: a test a lane. Included once for each instruction set, inside
// foreach_target sources.
#include <volccd/query/rounding.hpp>

#if defined(VOLCCD_TEST_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_TEST_LANES_INL
#undef VOLCCD_TEST_LANES_INL
#else
#define VOLCCD_TEST_LANES_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

struct Vector {
  V x, y, z;
};

// Products and sums are written out: a fused multiply-add would change bits from one processor to the next.
HWY_ATTR HWY_INLINE V difference(V a, V b, V c, V d) { return hn::Sub(hn::Mul(a, b), hn::Mul(c, d)); }
HWY_ATTR HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x)};
}
HWY_ATTR HWY_INLINE Vector sum(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_ATTR HWY_INLINE V dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

// Greatest magnitudes at both ends, not below kLeastExtent.
HWY_ATTR HWY_INLINE V extent(V start, V end) {
  return hn::Max(hn::Max(hn::Abs(start), hn::Abs(end)), hn::Set(D(), kLeastExtent));
}
HWY_ATTR HWY_INLINE Vector extent(const Vector& start, const Vector& end) {
  return {extent(start.x, end.x), extent(start.y, end.y), extent(start.z, end.z)};
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
