#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/narrowphase/detail/clearly_separated.cpp"
#include <hwy/foreach_target.h>
#include <volccd/narrowphase/detail/clearly_separated.hpp>
#include <volccd/query/block_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Quotient in [0, 1]. NaN or any value in it if the denominator is zero: degenerate features.
HWY_INLINE Lanes clamped_ratio(Lanes numerator, Lanes denominator) {
  return hn::Min(hn::Max(hn::Div(numerator, denominator), hn::Zero(Tag())), broadcast(1));
}

/// The point of the segment from a to b that is nearest to the origin.
HWY_INLINE Lanes3 nearest_of_segment(const Lanes3& a, const Lanes3& b) {
  const Lanes3 e = sub(b, a);
  return add(a, scaled(e, clamped_ratio(hn::Neg(dot(a, e)), dot(e, e))));
}

HWY_INLINE Lanes3 nearer(const Lanes3& a, const Lanes3& b) { return select(hn::Lt(dot(b, b), dot(a, a)), b, a); }

/// A multiple of the vector from the origin to the nearest point of a triangle.
HWY_INLINE Lanes3 towards_triangle(const Lanes3& a, const Lanes3& b, const Lanes3& c) {
  const Lanes3 n = cross(sub(b, a), sub(c, a));
  const Lanes inside = hn::Min(hn::Min(dot(n, cross(a, b)), dot(n, cross(b, c))), dot(n, cross(c, a)));
  const Lanes3 border = nearer(nearer(nearest_of_segment(a, b), nearest_of_segment(b, c)), nearest_of_segment(c, a));
  return select(hn::Gt(inside, hn::Zero(Tag())), n, border);
}

/// The vector from the nearest point of the segment from the origin to p1 to that of the segment from p2 to p3
/// (Ericson, Real-Time Collision Detection, 5.1.9).
HWY_INLINE Lanes3 between_edges(const Lanes3& p1, const Lanes3& p2, const Lanes3& p3) {
  const Lanes3 e = sub(p3, p2);
  const Lanes a = dot(p1, p1), b = dot(p1, e), c = dot(e, e), r1 = dot(p1, p2), r2 = dot(e, p2);
  const Lanes on_first = clamped_ratio(hn::Sub(hn::Mul(r1, c), hn::Mul(b, r2)), hn::Sub(hn::Mul(a, c), hn::Mul(b, b)));
  const Lanes on_second = clamped_ratio(hn::Sub(hn::Mul(b, on_first), r2), c);
  const Lanes nearest = clamped_ratio(hn::Add(hn::Mul(b, on_second), r1), a);
  return sub(add(p2, scaled(e, on_second)), scaled(p1, nearest));
}

/// The tests in one vector register.
template <FeatureKind kKind, int kControlPoints>
class ClearTests {
 public:
  template <std::size_t kDistance>
  HWY_INLINE ClearTests(Columns<kDistance> tests, double separation)
      : e_(tests, StepInterval(1, kControlPoints)), separation_(separation * kLengthSlack) {
    size_ = trusted(greatest_coordinate(max(max(e_.extent[0], e_.extent[1]), e_.extent[2])));
  }

  HWY_INLINE LaneMask along_coordinates() const {
    Gap<kKind> x, y, z;
    for (int c = 0; c < kControlPoints; ++c) {
      const Lanes3 &p1 = e_.at[0][c], &p2 = e_.at[1][c], &p3 = e_.at[2][c];
      x.include(p1.x, p2.x, p3.x);
      y.include(p1.y, p2.y, p3.y);
      z.include(p1.z, p2.z, p3.z);
    }
    const Lanes widest = hn::Max(hn::Max(x.greatest(), y.greatest()), z.greatest());
    return hn::Gt(widest, hn::Add(broadcast(separation_), hn::Mul(size_, broadcast(kClearMargin))));
  }

  HWY_INLINE LaneMask between_closest_points() const {
    const Lanes3 p1 = middle(0), p2 = middle(1), p3 = middle(2);
    const Lanes3 axis = kKind == FeatureKind::vf ? towards_triangle(p1, p2, p3) : between_edges(p1, p2, p3);
    const Lanes margin = hn::Mul(hn::Mul(norm1(axis), size_), broadcast(kClearMargin));
    const Lanes distance = hn::Mul(length(axis), broadcast(separation_));
    return hn::Gt(gap_along<kKind>(axis, e_), hn::Add(hn::Add(margin, broadcast(kGapUnderflow)), distance));
  }

 private:
  /// A multiple of the difference at t = 1/2.
  HWY_INLINE Lanes3 middle(int i) const {
    const Lanes3 ends = add(e_.at[i][0], e_.at[i][kControlPoints - 1]);
    return kControlPoints == 2 ? ends : add(ends, add(e_.at[i][1], e_.at[i][1]));
  }

  Differences<kControlPoints> e_;
  Lanes size_;
  double separation_;
};

template <FeatureKind kKind, int kControlPoints>
void drop_clear_tests(const TestBlock& block, double separation, std::span<std::uint8_t> keep) {
  using Tests = ClearTests<kKind, kControlPoints>;
  drop_tests(block, keep, [&](auto tests) HWY_ATTR { return Tests(tests, separation).along_coordinates(); });
  drop_kept_tests(block, keep, [&](auto tests) HWY_ATTR { return Tests(tests, separation).between_closest_points(); });
}

void drop_separated(const TestBlock& block, double separation, std::span<std::uint8_t> keep) {
  const bool vf = block.kind() == FeatureKind::vf;
  if (block.control_points() == 2)
    (vf ? drop_clear_tests<FeatureKind::vf, 2> : drop_clear_tests<FeatureKind::ee, 2>)(block, separation, keep);
  if (block.control_points() == 3)
    (vf ? drop_clear_tests<FeatureKind::vf, 3> : drop_clear_tests<FeatureKind::ee, 3>)(block, separation, keep);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(drop_separated);

void drop_clearly_separated(const TestBlock& block, double separation, std::span<std::uint8_t> keep) {
  HWY_DYNAMIC_DISPATCH(drop_separated)(block, separation, keep);
}

}  // namespace volccd::detail
#endif
