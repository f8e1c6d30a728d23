#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/narrowphase/inclusion/detail/crossing_block.cpp"
#include <hwy/foreach_target.h>
#include <volccd/narrowphase/inclusion/detail/crossing_block.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_bounds.hpp>
#include <volccd/numerics/vector_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

HWY_ATTR HWY_INLINE Lanes clamp01(Lanes x) { return hn::Min(hn::Max(x, hn::Zero(Tag())), broadcast(1)); }
HWY_ATTR HWY_INLINE Lanes between(Lanes a, Lanes b, Lanes t) {
  return hn::Add(hn::Mul(hn::Sub(broadcast(1), t), a), hn::Mul(t, b));
}
HWY_ATTR HWY_INLINE Lanes3 between(const Lanes3& a, const Lanes3& b, Lanes t) {
  return {between(a.x, b.x, t), between(a.y, b.y, t), between(a.z, b.z, t)};
}

/// The coplanarity cubic, multiplied by the sign that makes it positive at t = 0.
struct Cubic {
  Lanes b[4];   ///< Bernstein coefficients with binomials
  Lanes c[4];   ///< Bernstein coefficients without binomials
  Lanes error;  ///< error bound of a value, and of a coefficient over an interval

  HWY_ATTR HWY_INLINE Lanes value(Lanes s) const {
    const Lanes r = hn::Sub(broadcast(1), s), ss = hn::Mul(s, s);
    Lanes sum = hn::Add(hn::Mul(b[0], r), hn::Mul(b[1], s));
    sum = hn::Add(hn::Mul(sum, r), hn::Mul(b[2], ss));
    return hn::Add(hn::Mul(sum, r), hn::Mul(b[3], hn::Mul(ss, s)));
  }
};

HWY_ATTR HWY_INLINE Cubic load_cubic(const CrossingBlock::Rows& rows, std::size_t i) {
  const Tag d;
  Cubic cubic;
  for (int k = 0; k < 4; ++k) cubic.b[k] = hn::Load(d, rows.b[k] + i);
  const LaneMask turn = hn::Lt(cubic.b[0], hn::Zero(d));
  Lanes greatest = hn::Zero(d);
  for (int k = 0; k < 4; ++k) {
    cubic.b[k] = hn::IfThenElse(turn, hn::Neg(cubic.b[k]), cubic.b[k]);
    cubic.c[k] = k == 0 || k == 3 ? cubic.b[k] : hn::Mul(cubic.b[k], broadcast(1.0 / 3));
    greatest = hn::Max(greatest, hn::Abs(cubic.c[k]));
  }
  cubic.error = hn::Add(hn::Mul(hn::Load(d, rows.error + i), broadcast(kCubicErrorSlack)),
                        hn::Mul(greatest, broadcast(value_error_factor(3))));
  return cubic;
}

/// Whether the cubic is certainly positive up to s, and which sign it certainly has from s on.
struct Halves {
  LaneMask positive_before, negative_after, positive_after;
  Lanes rest[4];  ///< coefficients over the interval from s on

  HWY_ATTR HWY_INLINE Halves(const Cubic& cubic, Lanes s) : Halves(cubic.c, cubic.error, s) {}
  HWY_ATTR HWY_INLINE Halves(const Lanes (&c)[4], Lanes error, Lanes s) {
    const Lanes c01 = between(c[0], c[1], s), c12 = between(c[1], c[2], s), c23 = between(c[2], c[3], s);
    const Lanes c012 = between(c01, c12, s), c123 = between(c12, c23, s), middle = between(c012, c123, s);
    positive_before = hn::Gt(hn::Min(hn::Min(c[0], c01), hn::Min(c012, middle)), error);
    positive_after = hn::Gt(hn::Min(hn::Min(c[3], c23), hn::Min(c123, middle)), error);
    negative_after = hn::Lt(hn::Max(hn::Max(c[3], c23), hn::Max(c123, middle)), hn::Neg(error));
    rest[0] = middle;
    rest[1] = c123;
    rest[2] = c23;
    rest[3] = c[3];
  }
};

/// The derivative of the cubic divided by 3, as a s^2 + 2 h s + c0, and its properties. They are approximate; the roots
/// are verified later.
struct Shape {
  Lanes a, h, c0;
  Lanes min;           ///< position of the local minimum in [0,1], or 1/2
  Lanes root, second;  ///< the first root in [0,1], if `found`, and the next, if `again`
  LaneMask found, again;

  HWY_ATTR HWY_INLINE explicit Shape(const Cubic& cubic) {
    const Lanes zero = hn::Zero(Tag()), one = broadcast(1);
    const Lanes d0 = hn::Sub(cubic.c[1], cubic.c[0]), d1 = hn::Sub(cubic.c[2], cubic.c[1]),
                d2 = hn::Sub(cubic.c[3], cubic.c[2]);
    a = hn::Add(hn::Sub(d0, hn::Add(d1, d1)), d2);
    h = hn::Sub(d1, d0);
    c0 = d0;
    const Lanes root_of = hn::Sqrt(hn::Max(zero, hn::Sub(hn::Mul(h, h), hn::Mul(a, c0))));
    const Lanes minimum =
        hn::IfThenElse(hn::Lt(h, zero), hn::Div(hn::Sub(root_of, h), a), hn::Neg(hn::Div(c0, hn::Add(h, root_of))));
    const LaneMask inside = hn::And(hn::Gt(minimum, zero), hn::Lt(minimum, one));
    min = hn::IfThenElse(inside, minimum, broadcast(0.5));
    const LaneMask dips = hn::And(inside, hn::Lt(cubic.value(min), hn::Neg(cubic.error)));
    found = hn::And(hn::Gt(cubic.b[0], cubic.error), hn::Or(dips, hn::Lt(cubic.b[3], hn::Neg(cubic.error))));
    // Starting point from which Newton's method converges from one side: the inflection point between a maximum and a
    // minimum; 0 if a minimum comes first; 1 beyond a maximum that comes second.
    const Lanes inflection = clamp01(hn::Neg(hn::Div(h, a)));
    root = hn::IfThenElse(hn::Gt(a, zero), inflection, hn::IfThenElse(dips, zero, one));
    root = newton(cubic, root);
    again = hn::And(dips, hn::Gt(cubic.b[3], cubic.error));
    second = one;
    if (!hn::AllFalse(Tag(), again)) second = newton(cubic, hn::IfThenElse(hn::Gt(a, zero), one, inflection));
  }

  HWY_ATTR HWY_INLINE Lanes newton(const Cubic& cubic, Lanes x) const {
    for (int round = 0; round < 7; ++round) x = clamp01(hn::Sub(x, hn::Div(cubic.value(x), slope(x))));
    return x;
  }

  HWY_ATTR HWY_INLINE Lanes slope(Lanes s) const {
    return hn::Mul(broadcast(3), hn::Add(hn::Mul(hn::Add(hn::Mul(a, s), hn::Add(h, h)), s), c0));
  }
};

/// Differences of the points 1, 2, 3 at both ends of a short interval around the root.
struct ShortPiece {
  Lanes3 start[3], end[3];
  Lanes3 extents[3], extent;  ///< over the whole step
};

/// The same as MotionPiece::overlap_along.
class Overlap {
 public:
  HWY_ATTR HWY_INLINE Overlap(const ShortPiece& piece, const Lanes3& direction) : piece_(piece), l_(direction) {
    const Lanes3 m = abs(l_);
    underflow_ = hn::Mul(broadcast(kDeterminantUnderflow), hn::Add(broadcast(1), add3(m.x, m.y, m.z)));
    size_ = m;
  }

  HWY_ATTR HWY_INLINE LaneMask certain(bool edges) const {
    Lanes q12[3], q13[3], q23[3];
    quadric(0, 1, q12);
    quadric(0, 2, q13);
    quadric(1, 2, q23);
    const Lanes e12 = error(0, 1), e13 = error(0, 2), e23 = error(1, 2), zero = hn::Zero(Tag());
    const LaneMask turn = hn::Lt(q12[0], zero);
    LaneMask all = hn::MaskFromVec(zero);
    for (int k = 0; k < 3; ++k) {
      const Lanes weight = broadcast(k == 1 ? 2 : 1);
      const auto beyond = [&](Lanes x, Lanes bound)
                              HWY_ATTR { return hn::Gt(x, hn::Add(hn::Mul(weight, bound), underflow_)); };
      const auto turned = [&](Lanes x) HWY_ATTR { return hn::IfThenElse(turn, hn::Neg(x), x); };
      const Lanes s12 = turned(q12[k]), s31 = hn::Neg(turned(q13[k])), s23 = turned(q23[k]);
      LaneMask good = hn::And(beyond(s12, e12), beyond(s31, e13));
      if (edges) {
        const Lanes far = add3(s23, s12, s31);
        good = hn::And(good, beyond(hn::Neg(s23), e23));
        const Lanes bound = hn::Add(hn::Mul(weight, add3(e12, e13, e23)), hn::Mul(broadcast(3), underflow_));
        good = hn::And(good, hn::Gt(far, bound));
      } else {
        good = hn::And(good, beyond(s23, e23));
      }
      all = k == 0 ? good : hn::And(all, good);
    }
    return all;
  }

 private:
  HWY_ATTR HWY_INLINE void quadric(int i, int j, Lanes (&q)[3]) const {
    q[0] = dot(l_, cross(piece_.start[i], piece_.start[j]));
    q[1] = dot(l_, add(cross(piece_.start[i], piece_.end[j]), cross(piece_.end[i], piece_.start[j])));
    q[2] = dot(l_, cross(piece_.end[i], piece_.end[j]));
  }
  HWY_ATTR HWY_INLINE Lanes error(int i, int j) const {
    const Lanes3 &a = piece_.extents[i], &b = piece_.extents[j];
    const auto minor = [](Lanes p, Lanes q, Lanes r, Lanes s)
                           HWY_ATTR { return hn::Add(hn::Mul(p, q), hn::Mul(r, s)); };
    const Lanes sum = add3(hn::Mul(size_.x, minor(a.y, b.z, a.z, b.y)), hn::Mul(size_.y, minor(a.z, b.x, a.x, b.z)),
                           hn::Mul(size_.z, minor(a.x, b.y, a.y, b.x)));
    return hn::Mul(broadcast(quadric_error_factor(1)), sum);
  }

  const ShortPiece& piece_;
  Lanes3 l_, size_;
  Lanes underflow_;
};

/// The same as MotionPiece::separated_along, without a separation.
HWY_ATTR HWY_INLINE LaneMask separated(const ShortPiece& piece, const Lanes3& axis, bool edges) {
  const Lanes zero = hn::Zero(Tag());
  Lanes ahead = broadcast(0), behind = ahead;
  for (int end = 0; end < 2; ++end) {
    const Lanes3(&e)[3] = end == 0 ? piece.start : piece.end;
    const Lanes p1 = dot(axis, e[0]), p2 = dot(axis, e[1]), p3 = dot(axis, e[2]);
    const Lanes low = hn::Min(p2, p3), high = hn::Max(p2, p3);
    const Lanes above = edges ? hn::Sub(low, hn::Max(p1, zero)) : hn::Min(p1, low);
    const Lanes below = edges ? hn::Sub(hn::Min(p1, zero), high) : hn::Neg(hn::Max(p1, high));
    ahead = end == 0 ? above : hn::Min(ahead, above);
    behind = end == 0 ? below : hn::Min(behind, below);
  }
  const Lanes rounding =
      hn::Add(hn::Mul(broadcast(gap_error_factor(1)), dot(abs(axis), piece.extent)), broadcast(kGapUnderflow));
  return hn::Gt(hn::Max(ahead, behind), rounding);
}

/// The features around a root.
struct Look {
  LaneMask overlap, apart;

  HWY_ATTR HWY_INLINE Look(const CrossingBlock::Rows& rows, std::size_t i, Lanes root) {
    const Tag d;
    const Lanes margin = broadcast(kRootMargin);
    const Lanes lo = clamp01(hn::Sub(root, margin)), hi = clamp01(hn::Add(root, margin));
    const Lanes zero = hn::Zero(d);
    ShortPiece piece;
    piece.extent = {zero, zero, zero};
    Lanes3 at[3];
    for (std::size_t j = 0; j < 3; ++j) {
      const auto load = [&](std::size_t time) HWY_ATTR {
        return load3(d, rows.differences + (time * 3 + j) * 3 * CrossingBlock::kCapacity + i, CrossingBlock::kCapacity);
      };
      const Lanes3 start = load(0), end = load(1);
      piece.start[j] = between(start, end, lo);
      piece.end[j] = between(start, end, hi);
      at[j] = between(start, end, root);
      piece.extents[j] = extent(start, end);
      piece.extent = max(piece.extent, piece.extents[j]);
    }
    const Lanes3 first = rows.edges ? at[0] : sub(at[1], at[0]), second = sub(at[2], at[rows.edges ? 1 : 0]);
    const Lanes3 normal = cross(first, second);
    overlap = Overlap(piece, normal).certain(rows.edges);
    apart =
        hn::Or(separated(piece, cross(normal, first), rows.edges), separated(piece, cross(normal, second), rows.edges));
    if (!rows.edges) apart = hn::Or(apart, separated(piece, cross(normal, sub(second, first)), false));
  }
};

/// Two times that bracket a root and are sufficiently close to each other.
struct Bracket {
  Lanes before, after;
  LaneMask sharp;

  HWY_ATTR HWY_INLINE Bracket(const Cubic& cubic, const Shape& shape, Lanes root, double tolerance) {
    const Lanes relative = hn::Div(hn::Mul(broadcast(4), cubic.error), hn::Abs(shape.slope(root)));
    const Lanes margin = hn::Max(relative, broadcast(0x1p-40));
    before = hn::Max(hn::Zero(Tag()), hn::Sub(root, margin));
    after = hn::Min(broadcast(1), hn::Add(root, margin));
    sharp = hn::Lt(hn::Add(margin, margin), broadcast(std::min(tolerance, kRootMargin)));
  }
};

/// Examines at most two roots. A third root, for which the features must change sides back and forth, is left to the
/// search.
HWY_ATTR void decide_crossings(const CrossingBlock::Rows& rows, double tolerance) {
  const Tag d;
  const Lanes zero = hn::Zero(d), one = broadcast(1), backwards = broadcast(1 - 4 * kUnitRoundoff);
  for (std::size_t i = 0; i < rows.padded_size; i += hn::Lanes(d)) {
    const Cubic cubic = load_cubic(rows, i);
    const Shape shape(cubic);
    // There is no root if the cubic is positive on both sides of its minimum.
    const Halves around_min(cubic, shape.min);
    LaneMask apart = hn::And(around_min.positive_before, around_min.positive_after), touch = hn::MaskFromVec(zero);
    Lanes toi = zero, second = zero;
    if (!hn::AllFalse(d, shape.found)) {
      const Bracket root(cubic, shape, shape.root, tolerance);
      const LaneMask first = hn::And(hn::And(shape.found, root.sharp), Halves(cubic, root.before).positive_before);
      const Look look(rows, i, shape.root);
      touch = hn::And(hn::And(first, hn::Lt(cubic.value(root.after), hn::Neg(cubic.error))), look.overlap);
      toi = root.before;
      const Halves after(cubic, root.after);
      const LaneMask passed = hn::And(first, look.apart);
      apart = hn::Or(apart, hn::And(passed, after.negative_after));
      const LaneMask again = hn::AndNot(apart, hn::And(passed, shape.again));
      if (!hn::AllFalse(d, again)) {
        const Bracket next(cubic, shape, shape.second, tolerance);
        // Slightly later than `before`: by more than the rounding error of the parameter, and less than the margin.
        const Lanes until = hn::Add(next.before, broadcast(0x1p-44));
        const Lanes along = hn::Div(hn::Sub(until, root.after), hn::Sub(one, root.after));
        Lanes turned[4];
        for (int k = 0; k < 4; ++k) turned[k] = hn::Neg(after.rest[k]);
        const Halves between_roots(turned, hn::Add(cubic.error, cubic.error), clamp01(along));
        const LaneMask in_order = hn::And(between_roots.positive_before, hn::Lt(root.after, next.before));
        const LaneMask at_second = hn::And(hn::And(again, next.sharp), in_order);
        const Look at(rows, i, shape.second);
        const LaneMask crossed = hn::Gt(cubic.value(next.after), cubic.error);
        const LaneMask touch_again = hn::And(hn::And(at_second, crossed), at.overlap);
        touch = hn::Or(touch, touch_again);
        toi = hn::IfThenElse(touch_again, next.before, toi);
        second = hn::IfThenElseZero(touch_again, one);
        apart = hn::Or(apart, hn::And(hn::And(at_second, Halves(cubic, next.after).positive_after), at.apart));
      }
    }
    hn::Store(hn::IfThenElseZero(touch, one), d, rows.touch + i);
    hn::Store(hn::IfThenElseZero(apart, one), d, rows.apart + i);
    hn::Store(hn::Mul(toi, backwards), d, rows.toi + i);
    hn::Store(second, d, rows.second + i);
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(decide_crossings);

void CrossingBlock::gather(const TestBlock& tests, const CoplanarityBlock& cubics) {
  size_ = 0;
  edges_ = tests.kind() == FeatureKind::ee;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (!cubics.open(i)) continue;
    const CoplanarityCubic cubic = cubics.cubic(i);
    for (std::size_t k = 0; k < 4; ++k) b_[k][size_] = cubic.b[k];
    error_[size_] = cubic.error;
    double* difference = differences_ + size_;
    for (int time = 0; time < 2; ++time)
      for (int point = 1; point < 4; ++point)
        for (int axis = 0; axis < 3; ++axis, difference += kCapacity)
          *difference = tests.row(time, point, axis)[i] - tests.row(time, 0, axis)[i];
    source_[size_++] = static_cast<std::uint8_t>(i);
  }
  const std::size_t padded = (size_ + 7) / 8 * 8;
  for (std::size_t i = size_; i < padded; ++i) {
    for (std::size_t row = 0; row < 18; ++row) differences_[row * kCapacity + i] = 0;
    for (auto& b : b_) b[i] = 0;
    error_[i] = 0;
  }
}

void CrossingBlock::decide(double tolerance) {
  HWY_DYNAMIC_DISPATCH(decide_crossings)
  ({differences_, {b_[0], b_[1], b_[2], b_[3]}, error_, apart_, touch_, toi_, second_, (size_ + 7) / 8 * 8, edges_},
   tolerance);
}

}  // namespace volccd::detail
#endif
