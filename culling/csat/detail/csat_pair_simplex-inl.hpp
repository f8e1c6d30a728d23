// A simplex of the Gilbert-Johnson-Keerthi algorithm for each vector lane. Included once for each instruction set by
// foreach_target.h of Highway.
#include <volccd/culling/csat/detail/csat_pair_group-inl.hpp>

#if defined(VOLCCD_CSAT_PAIR_SIMPLEX_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_CSAT_PAIR_SIMPLEX_INL
#undef VOLCCD_CSAT_PAIR_SIMPLEX_INL
#else
#define VOLCCD_CSAT_PAIR_SIMPLEX_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Three points of a convex set, not necessarily distinct. As for GjkSimplex, rounding errors affect only the quality
/// of the direction. There are no branches, and there is no NaN for finite points of magnitudes between 2^-20 and 2^10.
class PairSimplex {
 public:
  HWY_INLINE explicit PairSimplex(const PairLanes3& point) : corners_{point, point, point} {}

  /// Lanes in which the point is already a corner.
  HWY_INLINE PairMask contains(const PairLanes3& p) const {
    const auto equal = [&](const PairLanes3& q)
                           HWY_ATTR { return hn::And(hn::And(hn::Eq(p.x, q.x), hn::Eq(p.y, q.y)), hn::Eq(p.z, q.z)); };
    return hn::Or(hn::Or(equal(corners_[0]), equal(corners_[1])), equal(corners_[2]));
  }

  /// Adds w and reduces the simplex to the face at w that is nearest to the origin. `axis` becomes a positive multiple
  /// of the nearest point of that face. Returns the lanes in which the origin is inside the simplex by a margin greater
  /// than all rounding errors; the axis of these lanes is undefined.
  HWY_INLINE PairMask extend(const PairLanes3& w, PairLanes3& axis) {
    for (int i = 0; i < 3; ++i) {
      side_[i] = sub(corners_[i], w);
      square_[i] = dot(side_[i], side_[i]);
      along_[i] = hn::Neg(dot(w, side_[i]));
    }
    for (int i = 0; i < 3; ++i) {
      normal_[i] = cross(side_[i], side_[(i + 1) % 3]);
      height_[i] = hn::Neg(dot(w, normal_[i]));
    }
    const PairMask inside = origin_inside(w);
    nearest_ = in_lanes(std::numeric_limits<float>::infinity());
    axis = w;
    PairLanes3 second = w, third = w;
    for (int i = 0; i < 3; ++i) try_segment(i, w, axis, second, third);
    for (int i = 0; i < 3; ++i) try_triangle(i, axis, second, third);
    corners_[0] = w;
    corners_[1] = second;
    corners_[2] = third;
    return inside;
  }

  /// Lanes in which a point of the simplex is nearer to the origin than `distance`. The rounding error is about 1e-6
  /// times the size of the simplex.
  HWY_INLINE PairMask nearer_than(PairLanes distance) const {
    return hn::And(hn::Gt(distance, in_lanes(0)), hn::Lt(nearest_, hn::Mul(distance, distance)));
  }

 private:
  /// The heights are the coordinates of the origin in the basis of the sides, multiplied by the volume of the simplex.
  HWY_INLINE PairMask origin_inside(const PairLanes3& w) const {
    const PairLanes volume = dot(normal_[0], side_[2]);
    const PairLanes size = hn::Max(hn::Max(square_[0], square_[1]), hn::Max(square_[2], dot(w, w)));
    const PairLanes margin = hn::Mul(in_lanes(kInsideMargin), hn::Mul(size, hn::Sqrt(size)));
    const auto oriented = [&](PairLanes x)
                              HWY_ATTR { return hn::IfThenElse(hn::Lt(volume, in_lanes(0)), hn::Neg(x), x); };
    const PairLanes h0 = oriented(height_[0]), h1 = oriented(height_[1]), h2 = oriented(height_[2]);
    const PairLanes fourth = hn::Sub(hn::Abs(volume), add3(h0, h1, h2));
    return hn::Gt(hn::Min(hn::Min(h0, h1), hn::Min(h2, fourth)), margin);
  }

  HWY_INLINE void try_segment(int i, const PairLanes3& w, PairLanes3& axis, PairLanes3& second, PairLanes3& third) {
    const PairLanes t = hn::Div(along_[i], hn::Max(square_[i], in_lanes(0x1p-80f)));
    const PairLanes3 x = add(w, scaled(side_[i], hn::Min(hn::Max(t, in_lanes(0)), in_lanes(1))));
    const PairLanes distance = dot(x, x);
    const PairMask nearer = hn::Lt(distance, nearest_);
    nearest_ = hn::IfThenElse(nearer, distance, nearest_);
    axis = select(nearer, x, axis);
    second = select(nearer, corners_[i], second);
    third = second;
  }

  /// Applies only if the point nearest to the origin is in the interior of the triangle.
  HWY_INLINE void try_triangle(int i, PairLanes3& axis, PairLanes3& second, PairLanes3& third) {
    const int j = (i + 1) % 3;
    const PairLanes both = dot(side_[i], side_[j]), area = dot(normal_[i], normal_[i]);
    const PairLanes a = hn::Sub(hn::Mul(square_[j], along_[i]), hn::Mul(both, along_[j]));
    const PairLanes b = hn::Sub(hn::Mul(square_[i], along_[j]), hn::Mul(both, along_[i]));
    const PairLanes zero = in_lanes(0);
    const PairMask interior = hn::And(hn::Gt(hn::Min(a, b), zero), hn::Lt(hn::Add(a, b), area));
    const PairLanes distance = hn::Div(hn::Mul(height_[i], height_[i]), area);
    const PairMask nearer = hn::And(interior, hn::Le(distance, nearest_));
    nearest_ = hn::IfThenElse(nearer, distance, nearest_);
    const PairMask behind = hn::Gt(height_[i], zero);
    const PairLanes sign = hn::IfThenElse(behind, in_lanes(-1), in_lanes(1));
    axis = select(nearer, scaled(normal_[i], sign), axis);
    second = select(nearer, corners_[i], second);
    third = select(nearer, corners_[j], third);
  }

  static constexpr float kInsideMargin = 4e-6f;  ///< relative to the cubed size of the simplex; 64 rounding errors

  PairLanes3 corners_[3], side_[3], normal_[3];
  PairLanes square_[3], along_[3], height_[3], nearest_;
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
