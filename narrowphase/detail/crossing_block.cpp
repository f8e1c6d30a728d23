#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/narrowphase/detail/crossing_block.cpp"
#include <hwy/foreach_target.h>
#include <volccd/narrowphase/detail/crossing_block.hpp>
#include <volccd/narrowphase/detail/inclusion_bounds.hpp>
#include <volccd/narrowphase/detail/test_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

using M = hn::Mask<D>;

HWY_ATTR HWY_INLINE V set(double x) { return hn::Set(D(), x); }
HWY_ATTR HWY_INLINE V plus3(V a, V b, V c) { return hn::Add(hn::Add(a, b), c); }
HWY_ATTR HWY_INLINE V clamp01(V x) { return hn::Min(hn::Max(x, hn::Zero(D())), set(1)); }
HWY_ATTR HWY_INLINE Vector minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_ATTR HWY_INLINE V between(V a, V b, V t) { return hn::Add(hn::Mul(hn::Sub(set(1), t), a), hn::Mul(t, b)); }
HWY_ATTR HWY_INLINE Vector between(const Vector& a, const Vector& b, V t) {
  return {between(a.x, b.x, t), between(a.y, b.y, t), between(a.z, b.z, t)};
}
HWY_ATTR HWY_INLINE Vector magnitude(const Vector& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }

/// The coplanarity cubic, times the sign that makes it positive at t = 0.
struct Cubic {
  V b[4];      ///< Bernstein coefficients with binomials
  V c[4];      ///< and without
  V error;     ///< of a value, and of a coefficient over a part

  HWY_ATTR HWY_INLINE V value(V s) const {
    const V r = hn::Sub(set(1), s), ss = hn::Mul(s, s);
    V sum = hn::Add(hn::Mul(b[0], r), hn::Mul(b[1], s));
    sum = hn::Add(hn::Mul(sum, r), hn::Mul(b[2], ss));
    return hn::Add(hn::Mul(sum, r), hn::Mul(b[3], hn::Mul(ss, s)));
  }
};

HWY_ATTR HWY_INLINE Cubic load_cubic(const CrossingBlock::Rows& rows, std::size_t i) {
  const D d;
  Cubic cubic;
  for (int k = 0; k < 4; ++k) cubic.b[k] = hn::Load(d, rows.b[k] + i);
  const M turn = hn::Lt(cubic.b[0], hn::Zero(d));
  V greatest = hn::Zero(d);
  for (int k = 0; k < 4; ++k) {
    cubic.b[k] = hn::IfThenElse(turn, hn::Neg(cubic.b[k]), cubic.b[k]);
    cubic.c[k] = k == 0 || k == 3 ? cubic.b[k] : hn::Mul(cubic.b[k], set(1.0 / 3));
    greatest = hn::Max(greatest, hn::Abs(cubic.c[k]));
  }
  cubic.error = hn::Add(hn::Mul(hn::Load(d, rows.error + i), set(kCubicErrorSlack)),
                        hn::Mul(greatest, set(value_error_factor(3))));
  return cubic;
}

/// Whether the cubic is positive up to s, and of which sign from s on, for certain.
struct Halves {
  M positive_before, negative_after, positive_after;
  V rest[4];  ///< coefficients from s on

  HWY_ATTR HWY_INLINE Halves(const Cubic& cubic, V s) : Halves(cubic.c, cubic.error, s) {}
  HWY_ATTR HWY_INLINE Halves(const V (&c)[4], V error, V s) {
    const V c01 = between(c[0], c[1], s), c12 = between(c[1], c[2], s), c23 = between(c[2], c[3], s);
    const V c012 = between(c01, c12, s), c123 = between(c12, c23, s), middle = between(c012, c123, s);
    positive_before = hn::Gt(hn::Min(hn::Min(c[0], c01), hn::Min(c012, middle)), error);
    positive_after = hn::Gt(hn::Min(hn::Min(c[3], c23), hn::Min(c123, middle)), error);
    negative_after = hn::Lt(hn::Max(hn::Max(c[3], c23), hn::Max(c123, middle)), hn::Neg(error));
    rest[0] = middle;
    rest[1] = c123;
    rest[2] = c23;
    rest[3] = c[3];
  }
};

/// The cubic's derivative over 3, as a s^2 + 2 h s + c0, and what it tells. No certainty: the root is checked later.
struct Shape {
  V a, h, c0;
  V least;         ///< local minimum in [0,1], or 1/2
  V root, second;  ///< the first in [0,1], if `found`, and the next, if `again`
  M found, again;

  HWY_ATTR HWY_INLINE explicit Shape(const Cubic& cubic) {
    const V zero = hn::Zero(D()), one = set(1);
    const V d0 = hn::Sub(cubic.c[1], cubic.c[0]), d1 = hn::Sub(cubic.c[2], cubic.c[1]), d2 = hn::Sub(cubic.c[3], cubic.c[2]);
    a = hn::Add(hn::Sub(d0, hn::Add(d1, d1)), d2);
    h = hn::Sub(d1, d0);
    c0 = d0;
    const V root_of = hn::Sqrt(hn::Max(zero, hn::Sub(hn::Mul(h, h), hn::Mul(a, c0))));
    const V minimum = hn::IfThenElse(hn::Lt(h, zero), hn::Div(hn::Sub(root_of, h), a),
                                     hn::Neg(hn::Div(c0, hn::Add(h, root_of))));
    const M inside = hn::And(hn::Gt(minimum, zero), hn::Lt(minimum, one));
    least = hn::IfThenElse(inside, minimum, set(0.5));
    const M dips = hn::And(inside, hn::Lt(cubic.value(least), hn::Neg(cubic.error)));
    found = hn::And(hn::Gt(cubic.b[0], cubic.error), hn::Or(dips, hn::Lt(cubic.b[3], hn::Neg(cubic.error))));
    // Where Newton's method converges from one side: the inflection point between a maximum and a minimum; for a minimum
    // that comes first, 0; beyond the maximum after it, 1.
    const V inflection = clamp01(hn::Neg(hn::Div(h, a)));
    root = hn::IfThenElse(hn::Gt(a, zero), inflection, hn::IfThenElse(dips, zero, one));
    root = newton(cubic, root);
    again = hn::And(dips, hn::Gt(cubic.b[3], cubic.error));
    second = one;
    if (!hn::AllFalse(D(), again)) second = newton(cubic, hn::IfThenElse(hn::Gt(a, zero), one, inflection));
  }

  HWY_ATTR HWY_INLINE V newton(const Cubic& cubic, V x) const {
    for (int round = 0; round < 7; ++round) x = clamp01(hn::Sub(x, hn::Div(cubic.value(x), slope(x))));
    return x;
  }

  HWY_ATTR HWY_INLINE V slope(V s) const {
    return hn::Mul(set(3), hn::Add(hn::Mul(hn::Add(hn::Mul(a, s), hn::Add(h, h)), s), c0));
  }
};

/// Points 1, 2, 3 around the root: at both ends of a short piece.
struct ShortPiece {
  Vector start[3], end[3];
  Vector extents[3], extent;  ///< of the whole step
};

/// As MotionPiece::overlap_along.
class Overlap {
 public:
  HWY_ATTR HWY_INLINE Overlap(const ShortPiece& piece, const Vector& direction) : piece_(piece), l_(direction) {
    const Vector m = magnitude(l_);
    underflow_ = hn::Mul(set(kDeterminantUnderflow), hn::Add(set(1), plus3(m.x, m.y, m.z)));
    size_ = m;
  }

  HWY_ATTR HWY_INLINE M certain(bool edges) const {
    V q12[3], q13[3], q23[3];
    quadric(0, 1, q12);
    quadric(0, 2, q13);
    quadric(1, 2, q23);
    const V e12 = error(0, 1), e13 = error(0, 2), e23 = error(1, 2), zero = hn::Zero(D());
    const M turn = hn::Lt(q12[0], zero);
    M all = hn::MaskFromVec(zero);
    for (int k = 0; k < 3; ++k) {
      const V weight = set(k == 1 ? 2 : 1);
      const auto beyond = [&](V x, V bound)
                              HWY_ATTR { return hn::Gt(x, hn::Add(hn::Mul(weight, bound), underflow_)); };
      const auto turned = [&](V x) HWY_ATTR { return hn::IfThenElse(turn, hn::Neg(x), x); };
      const V s12 = turned(q12[k]), s31 = hn::Neg(turned(q13[k])), s23 = turned(q23[k]);
      M good = hn::And(beyond(s12, e12), beyond(s31, e13));
      if (edges) {
        const V far = plus3(s23, s12, s31);
        good = hn::And(good, beyond(hn::Neg(s23), e23));
        good = hn::And(good, hn::Gt(far, hn::Add(hn::Mul(weight, plus3(e12, e13, e23)), hn::Mul(set(3), underflow_))));
      } else {
        good = hn::And(good, beyond(s23, e23));
      }
      all = k == 0 ? good : hn::And(all, good);
    }
    return all;
  }

 private:
  HWY_ATTR HWY_INLINE void quadric(int i, int j, V (&q)[3]) const {
    q[0] = dot(l_, cross(piece_.start[i], piece_.start[j]));
    q[1] = dot(l_, sum(cross(piece_.start[i], piece_.end[j]), cross(piece_.end[i], piece_.start[j])));
    q[2] = dot(l_, cross(piece_.end[i], piece_.end[j]));
  }
  HWY_ATTR HWY_INLINE V error(int i, int j) const {
    const Vector &a = piece_.extents[i], &b = piece_.extents[j];
    const auto minor = [](V p, V q, V r, V s) HWY_ATTR { return hn::Add(hn::Mul(p, q), hn::Mul(r, s)); };
    const V sum = plus3(hn::Mul(size_.x, minor(a.y, b.z, a.z, b.y)), hn::Mul(size_.y, minor(a.z, b.x, a.x, b.z)),
                        hn::Mul(size_.z, minor(a.x, b.y, a.y, b.x)));
    return hn::Mul(set(quadric_error_factor(1)), sum);
  }

  const ShortPiece& piece_;
  Vector l_, size_;
  V underflow_;
};

/// As MotionPiece::separated_along, no separation.
HWY_ATTR HWY_INLINE M separated(const ShortPiece& piece, const Vector& axis, bool edges) {
  const V zero = hn::Zero(D());
  V ahead = set(0), behind = ahead;
  for (int end = 0; end < 2; ++end) {
    const Vector(&e)[3] = end == 0 ? piece.start : piece.end;
    const V p1 = dot(axis, e[0]), p2 = dot(axis, e[1]), p3 = dot(axis, e[2]);
    const V low = hn::Min(p2, p3), high = hn::Max(p2, p3);
    const V above = edges ? hn::Sub(low, hn::Max(p1, zero)) : hn::Min(p1, low);
    const V below = edges ? hn::Sub(hn::Min(p1, zero), high) : hn::Neg(hn::Max(p1, high));
    ahead = end == 0 ? above : hn::Min(ahead, above);
    behind = end == 0 ? below : hn::Min(behind, below);
  }
  const V rounding = hn::Add(hn::Mul(set(gap_error_factor(1)), dot(magnitude(axis), piece.extent)), set(kGapUnderflow));
  return hn::Gt(hn::Max(ahead, behind), rounding);
}

HWY_ATTR HWY_INLINE Vector greater(const Vector& a, const Vector& b) {
  return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}

/// The features around a root.
struct Look {
  M overlap, apart;

  HWY_ATTR HWY_INLINE Look(const CrossingBlock::Rows& rows, std::size_t i, V root) {
    const D d;
    const V lo = clamp01(hn::Sub(root, set(kRootMargin))), hi = clamp01(hn::Add(root, set(kRootMargin)));
    const V zero = hn::Zero(d);
    ShortPiece piece;
    piece.extent = {zero, zero, zero};
    Vector at[3];
    for (std::size_t j = 0; j < 3; ++j) {
      const auto load = [&](std::size_t time) HWY_ATTR {
        const double* row = rows.differences + (time * 3 + j) * 3 * CrossingBlock::kCapacity + i;
        return Vector{hn::Load(d, row), hn::Load(d, row + CrossingBlock::kCapacity),
                      hn::Load(d, row + 2 * CrossingBlock::kCapacity)};
      };
      const Vector start = load(0), end = load(1);
      piece.start[j] = between(start, end, lo);
      piece.end[j] = between(start, end, hi);
      at[j] = between(start, end, root);
      piece.extents[j] = extent(start, end);
      piece.extent = greater(piece.extent, piece.extents[j]);
    }
    const Vector first = rows.edges ? at[0] : minus(at[1], at[0]), second = minus(at[2], at[rows.edges ? 1 : 0]);
    const Vector normal = cross(first, second);
    overlap = Overlap(piece, normal).certain(rows.edges);
    apart = hn::Or(separated(piece, cross(normal, first), rows.edges),
                   separated(piece, cross(normal, second), rows.edges));
    if (!rows.edges) apart = hn::Or(apart, separated(piece, cross(normal, minus(second, first)), false));
  }
};

/// A root between two times that are close enough together.
struct Bracket {
  V before, after;
  M sharp;

  HWY_ATTR HWY_INLINE Bracket(const Cubic& cubic, const Shape& shape, V root, double tolerance) {
    const V margin = hn::Max(hn::Div(hn::Mul(set(4), cubic.error), hn::Abs(shape.slope(root))), set(0x1p-40));
    before = hn::Max(hn::Zero(D()), hn::Sub(root, margin));
    after = hn::Min(set(1), hn::Add(root, margin));
    sharp = hn::Lt(hn::Add(margin, margin), set(std::min(tolerance, kRootMargin)));
  }
};

/// At most two roots are looked at: with a third, which needs the features to change sides back and forth, others decide.
HWY_ATTR void decide_crossings(const CrossingBlock::Rows& rows, double tolerance) {
  const D d;
  const V zero = hn::Zero(d), one = set(1), backwards = set(1 - 4 * kUnitRoundoff);
  for (std::size_t i = 0; i < rows.padded_size; i += hn::Lanes(d)) {
    const Cubic cubic = load_cubic(rows, i);
    const Shape shape(cubic);
    // No root at all: positive on both sides of the minimum.
    const Halves around_least(cubic, shape.least);
    M apart = hn::And(around_least.positive_before, around_least.positive_after), touch = hn::MaskFromVec(zero);
    V toi = zero, second = zero;
    if (!hn::AllFalse(d, shape.found)) {
      const Bracket root(cubic, shape, shape.root, tolerance);
      const M first = hn::And(hn::And(shape.found, root.sharp), Halves(cubic, root.before).positive_before);
      const Look look(rows, i, shape.root);
      touch = hn::And(hn::And(first, hn::Lt(cubic.value(root.after), hn::Neg(cubic.error))), look.overlap);
      toi = root.before;
      const Halves after(cubic, root.after);
      const M passed = hn::And(first, look.apart);
      apart = hn::Or(apart, hn::And(passed, after.negative_after));
      const M again = hn::AndNot(apart, hn::And(passed, shape.again));
      if (!hn::AllFalse(d, again)) {
        const Bracket next(cubic, shape, shape.second, tolerance);
        // A little further than `before`: more than the parameter is rounded by, less than the margin.
        const V until = hn::Add(next.before, set(0x1p-44));
        const V along = hn::Div(hn::Sub(until, root.after), hn::Sub(one, root.after));
        V turned[4];
        for (int k = 0; k < 4; ++k) turned[k] = hn::Neg(after.rest[k]);
        const M between_roots = Halves(turned, hn::Add(cubic.error, cubic.error), clamp01(along)).positive_before;
        const M at_second = hn::And(hn::And(again, next.sharp), hn::And(between_roots, hn::Lt(root.after, next.before)));
        const Look at(rows, i, shape.second);
        const M touch_again = hn::And(hn::And(at_second, hn::Gt(cubic.value(next.after), cubic.error)), at.overlap);
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

void CrossingBlock::gather(const CoplanarityBlock& block) {
  size_ = 0;
  edges_ = block.kind() == FeatureKind::ee;
  for (std::size_t i = 0; i < block.size(); ++i) {
    if (!block.open(i)) continue;
    const CoplanarityCubic cubic = block.cubic(i);
    for (std::size_t k = 0; k < 4; ++k) b_[k][size_] = cubic.b[k];
    error_[size_] = cubic.error;
    for (std::size_t row = 0; row < 18; ++row)
      differences_[row * kCapacity + size_] = block.difference(i, row / 9, row / 3 % 3, row % 3);
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
  ({differences_, {b_[0], b_[1], b_[2], b_[3]}, error_, apart_, touch_, toi_, second_, (size_ + 7) / 8 * 8, edges_}, tolerance);
}

}  // namespace volccd::detail
#endif
