// What the feature filters share: a test a lane. Included once for each instruction set, inside foreach_target sources.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <volccd/query/test_block.hpp>
#include <volccd/query/rounding.hpp>

#if defined(VOLCCD_FILTER_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_FILTER_LANES_INL
#undef VOLCCD_FILTER_LANES_INL
#else
#define VOLCCD_FILTER_LANES_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 8>;  // blocks are padded to 8
using Lanes = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;

HWY_INLINE Lanes same(double x) { return hn::Set(Tag(), x); }

HWY_INLINE Lanes add3(Lanes x, Lanes y, Lanes z) { return hn::Add(hn::Add(x, y), z); }

struct Lanes3 {
  Lanes x, y, z;
};
HWY_INLINE Lanes3 sub(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Lanes3 add(const Lanes3& a, const Lanes3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Lanes3 times(const Lanes3& a, double b) {
  return {hn::Mul(a.x, same(b)), hn::Mul(a.y, same(b)), hn::Mul(a.z, same(b))};
}
HWY_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) {
  return add3(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z));
}
HWY_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Lanes3 abs(const Lanes3& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
HWY_INLINE Lanes3 max(const Lanes3& a, const Lanes3& b) {
  return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}
/// x, or infinity where x is not below kGreatestMagnitude.
HWY_INLINE Lanes trusted(Lanes x) {
  return hn::IfThenElse(hn::Lt(x, same(kGreatestMagnitude)), x, same(std::numeric_limits<double>::infinity()));
}
/// At least the length, up to a factor that kLengthSlack makes up for.
HWY_INLINE Lanes length(const Lanes3& a) {
  const Lanes square = dot(a, a);
  const Lanes3 m = abs(a);
  return hn::IfThenElse(hn::Gt(square, same(kLeastSquare)), hn::Sqrt(square), add3(m.x, m.y, m.z));
}
HWY_INLINE Lanes3 load(const TestBlock& block, int control_point, int vertex, std::size_t i) {
  const Tag tag;
  return {hn::Load(tag, block.row(control_point, vertex, 0) + i),
          hn::Load(tag, block.row(control_point, vertex, 1) + i),
          hn::Load(tag, block.row(control_point, vertex, 2) + i)};
}

/// The part [0, s] of the step that a query asks for.
struct Part {
  int levels;  ///< of de Casteljau's scheme; 0: all of the step
  double s, rest;

  Part(double t_max, int control_points)
      : levels(t_max < 1 ? control_points - 1 : 0), s(std::max(t_max, 0.0)), rest(1 - s) {}
};

/// Control points of the motion over the part, in place.
template <int kControlPoints>
HWY_INLINE void restrict_to(const Part& part, Lanes3 (&points)[kControlPoints]) {
  for (int level = 1; level <= part.levels; ++level)
    for (int c = kControlPoints - 1; c >= level; --c)
      points[c] = add(times(points[c - 1], part.rest), times(points[c], part.s));
}

/// Vertices 1..3 relative to vertex 0.
template <int kControlPoints>
struct Differences {
  Lanes3 at[3][kControlPoints];
  Lanes3 extent[3];  ///< greatest magnitudes over the control points of the whole step; infinite where not trusted

  HWY_INLINE Differences(const TestBlock& block, const Part& part, std::size_t i) {
    const Lanes least = same(kLeastExtent);
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
