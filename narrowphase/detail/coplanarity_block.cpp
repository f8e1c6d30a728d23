#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/narrowphase/detail/coplanarity_block.cpp"
#include <hwy/foreach_target.h>
#include <volccd/narrowphase/detail/coplanarity_block.hpp>
#include <volccd/numerics/vector_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Whether, along one axis, the second feature is beyond the first in the same order at both ends. `start`, `end`:
/// coordinates of the differences 1, 2, 3; point 0 is the origin. Coordinates are compared, not subtracted: if
/// differences have overflowed to infinity, subtraction would give NaN, which a minimum may discard.
HWY_ATTR HWY_INLINE LaneMask apart(bool edges, const Lanes (&start)[3], const Lanes (&end)[3]) {
  const Lanes zero = hn::Zero(Tag());
  const auto gaps = [&](const Lanes(&d)[3], LaneMask* above, LaneMask* below) HWY_ATTR {
    const Lanes low = hn::Min(d[1], d[2]), high = hn::Max(d[1], d[2]);
    if (edges) {
      *above = hn::Gt(low, hn::Max(zero, d[0]));
      *below = hn::Lt(high, hn::Min(zero, d[0]));
    } else {
      *above = hn::Gt(hn::Min(low, d[0]), zero);
      *below = hn::Lt(hn::Max(high, d[0]), zero);
    }
  };
  LaneMask above0, below0, above1, below1;
  gaps(start, &above0, &below0);
  gaps(end, &above1, &below1);
  return hn::Or(hn::And(above0, above1), hn::And(below0, below1));
}

HWY_ATTR HWY_INLINE LaneMask axis_apart(bool edges, const Lanes3 (&start)[3], const Lanes3 (&end)[3]) {
  const Lanes sx[3] = {start[0].x, start[1].x, start[2].x}, ex[3] = {end[0].x, end[1].x, end[2].x};
  const Lanes sy[3] = {start[0].y, start[1].y, start[2].y}, ey[3] = {end[0].y, end[1].y, end[2].y};
  const Lanes sz[3] = {start[0].z, start[1].z, start[2].z}, ez[3] = {end[0].z, end[1].z, end[2].z};
  return hn::Or(hn::Or(apart(edges, sx, ex), apart(edges, sy, ey)), apart(edges, sz, ez));
}

/// Bound on the error of each Bernstein coefficient (without its binomial); infinite if an overflow or underflow is
/// possible.
HWY_ATTR HWY_INLINE Lanes error_bound(const Lanes3 (&start)[3], const Lanes3 (&end)[3]) {
  const Tag d;
  const Lanes3 e1 = extent(start[0], end[0]), e2 = extent(start[1], end[1]), e3 = extent(start[2], end[2]);
  const auto minor = [](Lanes a, Lanes b, Lanes c, Lanes e) HWY_ATTR { return hn::Add(hn::Mul(a, b), hn::Mul(c, e)); };
  const Lanes permanent =
      hn::Add(hn::Add(hn::Mul(e1.x, minor(e2.y, e3.z, e2.z, e3.y)), hn::Mul(e1.y, minor(e2.z, e3.x, e2.x, e3.z))),
              hn::Mul(e1.z, minor(e2.x, e3.y, e2.y, e3.x)));
  const Lanes size = hn::Max(hn::Max(greatest_coordinate(e1), greatest_coordinate(e2)), greatest_coordinate(e3));
  const Lanes slack = broadcast(kDeterminantUnderflow * (1 + 3 * kGreatestSize));
  const Lanes bound = hn::Add(hn::Mul(broadcast(determinant_error_factor(2, 0)), permanent), slack);
  const auto ordinary = hn::And(hn::Ge(size, broadcast(kMinSize)), hn::Le(size, broadcast(kGreatestSize)));
  return hn::IfThenElse(ordinary, bound, hn::Inf(d));
}

HWY_ATTR void compute_rows(const TestBlock& tests, bool axis_test, bool coplanarity,
                           const CoplanarityBlock::Rows& rows) {
  const Tag d;
  const bool edges = tests.kind() == FeatureKind::ee;
  for (std::size_t i = 0; i < tests.padded_size(); i += hn::Lanes(d)) {
    Lanes3 p[2][3];  // points 1, 2, 3 relative to point 0
    for (int time = 0; time < 2; ++time) {
      const auto point = [&](int v) HWY_ATTR { return load3(d, tests.row(time, v, 0) + i, TestBlock::kCapacity); };
      const Lanes3 origin = point(0);
      for (int j = 0; j < 3; ++j) p[time][j] = sub(point(j + 1), origin);
    }
    LaneMask closed = hn::MaskFromVec(hn::Zero(d));
    if (axis_test) {
      closed = axis_apart(edges, p[0], p[1]);
      if (hn::AllTrue(d, closed)) {
        hn::Store(hn::Zero(d), d, rows.open + i);
        continue;
      }
    }
    const Lanes3 n0 = cross(p[0][1], p[0][2]), n2 = cross(p[1][1], p[1][2]);
    const Lanes3 n1 = add(cross(p[0][1], p[1][2]), cross(p[1][1], p[0][2]));
    const Lanes b0 = dot(p[0][0], n0), b1 = hn::Add(dot(p[0][0], n1), dot(p[1][0], n0));
    const Lanes b2 = hn::Add(dot(p[0][0], n2), dot(p[1][0], n1)), b3 = dot(p[1][0], n2);
    const Lanes error = error_bound(p[0], p[1]), error3 = hn::Mul(broadcast(3.0), error), zero = hn::Zero(d);
    const auto positive = hn::And(hn::Gt(hn::Min(b0, b3), error), hn::Gt(hn::Min(b1, b2), error3));
    const auto negative =
        hn::And(hn::Lt(hn::Max(b0, b3), hn::Sub(zero, error)), hn::Lt(hn::Max(b1, b2), hn::Sub(zero, error3)));
    if (coplanarity) closed = hn::Or(closed, hn::Or(positive, negative));
    hn::Store(b0, d, rows.b[0] + i);
    hn::Store(b1, d, rows.b[1] + i);
    hn::Store(b2, d, rows.b[2] + i);
    hn::Store(b3, d, rows.b[3] + i);
    hn::Store(error, d, rows.error + i);
    hn::Store(hn::IfThenZeroElse(closed, broadcast(1.0)), d, rows.open + i);
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(compute_rows);

void CoplanarityBlock::compute(const TestBlock& tests, bool axis_test, bool coplanarity) {
  HWY_DYNAMIC_DISPATCH(compute_rows)
  (tests, axis_test, coplanarity, {{b_[0], b_[1], b_[2], b_[3]}, error_, open_});
}

}  // namespace volccd::detail
#endif
