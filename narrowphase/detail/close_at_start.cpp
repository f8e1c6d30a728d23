#include <cmath>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/narrowphase/detail/close_at_start.cpp"
#include <hwy/foreach_target.h>
#include <volccd/narrowphase/detail/close_at_start.hpp>
#include <volccd/query/block_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// As ClosestPoints.
struct ClosestLanes {
  Lanes weights[4];
  Lanes3 separation;
  Lanes square;
};

HWY_INLINE Lanes3 negated(const Lanes3& a) { return {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)}; }

/// closest_points() of a test in each lane, with the same operations in the same order.
template <FeatureKind kKind>
class ClosestSearch {
 public:
  HWY_ATTR HWY_INLINE explicit ClosestSearch(const Lanes3 (&d)[3]) : d_(d) {
    const Lanes zero = hn::Zero(Tag()), one = broadcast(1);
    const Lanes3 origin = {zero, zero, zero};
    best_.square = broadcast(std::numeric_limits<double>::infinity());
    for (Lanes& w : best_.weights) w = zero;
    best_.separation = origin;
    offer_insides();
    if constexpr (kKind == FeatureKind::vf) {
      Lanes s = parameter(origin, d[0], d[1]);
      offer({one, hn::Sub(one, s), s, zero});
      s = parameter(origin, d[1], d[2]);
      offer({one, zero, hn::Sub(one, s), s});
      s = parameter(origin, d[0], d[2]);
      offer({one, hn::Sub(one, s), zero, s});
    } else {
      Lanes s = parameter(origin, d[1], d[2]);
      offer({one, zero, hn::Sub(one, s), s});
      s = parameter(d[0], d[1], d[2]);
      offer({zero, one, hn::Sub(one, s), s});
      s = parameter(d[1], origin, d[0]);
      offer({hn::Sub(one, s), s, one, zero});
      s = parameter(d[2], origin, d[0]);
      offer({hn::Sub(one, s), s, zero, one});
    }
  }

  HWY_INLINE const ClosestLanes& best() const { return best_; }

 private:
  using Weights = Lanes[4];

  HWY_ATTR HWY_INLINE void offer(const Weights& w) { offer(w, hn::Eq(w[0], w[0])); }
  HWY_ATTR HWY_INLINE void offer(const Weights& w, LaneMask valid) {
    const Lanes3 first = scaled(d_[0], w[1]), second = scaled(d_[1], w[2]), third = scaled(d_[2], w[3]);
    const Lanes3 separation =
        kKind == FeatureKind::vf ? negated(add(add(first, second), third)) : sub(first, add(second, third));
    const Lanes square = dot(separation, separation);
    const LaneMask nearer = hn::And(valid, hn::Lt(square, best_.square));
    for (int i = 0; i < 4; ++i) best_.weights[i] = hn::IfThenElse(nearer, w[i], best_.weights[i]);
    best_.separation = select(nearer, separation, best_.separation);
    best_.square = hn::IfThenElse(nearer, square, best_.square);
  }

  /// Of the point of the segment from a to b that is closest to p.
  static HWY_ATTR HWY_INLINE Lanes parameter(const Lanes3& p, const Lanes3& a, const Lanes3& b) {
    const Lanes3 e = sub(b, a);
    const Lanes length = dot(e, e), ratio = hn::Div(dot(e, sub(p, a)), length), zero = hn::Zero(Tag());
    return hn::IfThenElseZero(hn::Gt(length, zero), hn::Min(hn::Max(ratio, zero), broadcast(1)));
  }

  /// The closest points of the planes of the features, or of the lines, if they are inside of the features. The second
  /// round corrects the error of the first.
  HWY_ATTR HWY_INLINE void offer_insides() {
    constexpr bool kVf = kKind == FeatureKind::vf;
    const Lanes3 e1 = kVf ? sub(d_[1], d_[0]) : d_[0], e2 = sub(d_[2], kVf ? d_[0] : d_[1]), n = cross(e1, e2);
    const Lanes area = dot(n, n), zero = hn::Zero(Tag()), one = broadcast(1);
    Lanes a = zero, b = zero;
    for (int round = 0; round < 2; ++round) {
      const Lanes3 q =
          kVf ? negated(add(add(d_[0], scaled(e1, a)), scaled(e2, b))) : sub(add(d_[1], scaled(e2, b)), scaled(e1, a));
      a = hn::Add(a, hn::Div(dot(n, cross(q, e2)), area));
      b = hn::Add(b, hn::Div(dot(n, kVf ? cross(e1, q) : cross(q, e1)), area));
    }
    const LaneMask valid = hn::And(hn::Gt(area, zero), hn::And(hn::Ge(a, zero), hn::Ge(b, zero)));
    if constexpr (kVf) {
      const Lanes w0 = hn::Sub(hn::Sub(one, a), b);
      offer({one, w0, a, b}, hn::And(valid, hn::Ge(w0, zero)));
    } else {
      offer({hn::Sub(one, a), a, hn::Sub(one, b), b}, hn::And(valid, hn::And(hn::Le(a, one), hn::Le(b, one))));
    }
  }

  const Lanes3 (&d_)[3];
  ClosestLanes best_;
};

/// As BoundedTest::at(0): the sign of zero differs from that of the first control point.
template <int kControlPoints>
HWY_INLINE Lanes at_start(const Lanes (&x)[kControlPoints]) {
  const Lanes zero = hn::Zero(Tag());
  if constexpr (kControlPoints == 2) return hn::Add(x[0], hn::Mul(x[1], zero));
  const Lanes first = hn::Add(x[0], hn::Mul(x[1], zero)), second = hn::Add(x[1], hn::Mul(x[2], zero));
  return hn::Add(first, hn::Mul(second, zero));
}

template <FeatureKind kKind, int kControlPoints>
HWY_ATTR void find_close_of(const TestBlock& block, double separation, std::span<const std::uint8_t> keep,
                            CloseAtStart::Rows& out) {
  const Tag tag;
  const double rounded_up = std::nextafter(separation, std::numeric_limits<double>::infinity());
  const Lanes one = broadcast(1), min_size = broadcast(kMinSize), max_size = broadcast(kGreatestSize);
  for (std::size_t i = 0; i < block.size(); i += hn::Lanes(tag)) {
    std::uint64_t flags = 0;
    std::memcpy(&flags, keep.data() + i, hn::Lanes(tag));
    hn::Store(hn::Zero(tag), tag, out.close + i);
    if (flags == 0) continue;
    const Differences<kControlPoints> e(BlockColumns{block.row(0, 0, 0) + i}, StepInterval(1, kControlPoints));
    Lanes3 d[3], extent = e.extent[0];
    for (int v = 0; v < 3; ++v) {
      extent = max(extent, e.extent[v]);
      Lanes x[kControlPoints], y[kControlPoints], z[kControlPoints];
      for (int c = 0; c < kControlPoints; ++c) x[c] = e.at[v][c].x, y[c] = e.at[v][c].y, z[c] = e.at[v][c].z;
      d[v] = {at_start<kControlPoints>(x), at_start<kControlPoints>(y), at_start<kControlPoints>(z)};
    }
    const ClosestLanes best = ClosestSearch<kKind>(d).best();
    // The bound of BoundedTest::distance_error().
    const Lanes error = hn::Add(hn::Mul(add3(extent.x, extent.y, extent.z), broadcast(kDistanceError)),
                                broadcast(32 * kUnitRoundoff * rounded_up));
    const Lanes gap = hn::Sub(hn::Sqrt(best.square), broadcast(rounded_up)), size = greatest_coordinate(extent);
    const LaneMask in_range = hn::And(hn::Ge(size, min_size), hn::Le(size, max_size));
    const LaneMask close = hn::And(hn::And(in_range, hn::Lt(gap, hn::Neg(error))), hn::Gt(best.square, hn::Zero(tag)));
    for (int k = 0; k < 4; ++k) hn::Store(best.weights[k], tag, out.weights[k] + i);
    hn::Store(best.separation.x, tag, out.separation[0] + i);
    hn::Store(best.separation.y, tag, out.separation[1] + i);
    hn::Store(best.separation.z, tag, out.separation[2] + i);
    hn::Store(best.square, tag, out.square + i);
    hn::Store(size, tag, out.size + i);
    hn::Store(hn::IfThenElseZero(close, one), tag, out.close + i);
  }
}

void find_close(const TestBlock& block, double separation, std::span<const std::uint8_t> keep,
                CloseAtStart::Rows& out) {
  const bool vf = block.kind() == FeatureKind::vf;
  if (block.control_points() == 2)
    (vf ? find_close_of<FeatureKind::vf, 2> : find_close_of<FeatureKind::ee, 2>)(block, separation, keep, out);
  if (block.control_points() == 3)
    (vf ? find_close_of<FeatureKind::vf, 3> : find_close_of<FeatureKind::ee, 3>)(block, separation, keep, out);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(find_close);

void CloseAtStart::find(const TestBlock& block, double separation, std::span<const std::uint8_t> keep) {
  HWY_DYNAMIC_DISPATCH(find_close)(block, separation, keep, rows_);
}

}  // namespace volccd::detail
#endif
