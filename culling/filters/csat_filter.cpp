#include <volccd/culling/filters/csat_filter.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/filters/csat_filter.cpp"
#include <hwy/foreach_target.h>
#include <volccd/query/block_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// The tests in one vector register.
template <FeatureKind kKind, int kControlPoints>
class SeparatingAxes {
 public:
  template <std::size_t kDistance>
  HWY_INLINE SeparatingAxes(Columns<kDistance> tests, double separation, const StepInterval& interval)
      : e_(tests, interval), factor_(gap_error_factor(interval.levels)), separation_(separation) {
    extent_ = trusted(max(max(e_.extent[0], e_.extent[1]), e_.extent[2]));
  }

  HWY_INLINE LaneMask along_normals(CsatFilterAxes axes) const {
    const LaneMask apart = separates(normal(0));
    if (axes == CsatFilterAxes::first || hn::AllTrue(Tag(), apart)) return apart;
    return hn::Or(apart, separates(normal(kControlPoints - 1)));
  }
  HWY_INLINE LaneMask across_edges() const {
    const Lanes3 n = normal(0);
    LaneMask apart = separates(cross(n, first_side(0)));
    apart = hn::Or(apart, separates(cross(n, second_side(0))));
    if constexpr (kKind == FeatureKind::vf)
      apart = hn::Or(apart, separates(cross(n, sub(second_side(0), first_side(0)))));
    return apart;
  }

 private:
  /// Normal of the triangle, or cross product of the edges, at a control point.
  HWY_INLINE Lanes3 normal(int c) const { return cross(first_side(c), second_side(c)); }
  /// Two sides of the triangle, or both edges.
  HWY_INLINE Lanes3 first_side(int c) const {
    return kKind == FeatureKind::vf ? sub(e_.at[1][c], e_.at[0][c]) : e_.at[0][c];
  }
  HWY_INLINE Lanes3 second_side(int c) const { return sub(e_.at[2][c], e_.at[kKind == FeatureKind::vf ? 0 : 1][c]); }

  HWY_INLINE LaneMask separates(const Lanes3& axis) const {
    return hn::Gt(gap_along<kKind>(axis, e_), gap_threshold(axis, extent_, factor_, separation_));
  }

  Differences<kControlPoints> e_;
  Lanes3 extent_;
  double factor_, separation_;
};

template <FeatureKind kKind, int kControlPoints>
void filter_block(const TestBlock& block, double separation, const StepInterval& interval, CsatFilterAxes axes,
                  std::span<std::uint8_t> keep) {
  using Axes = SeparatingAxes<kKind, kControlPoints>;
  drop_tests(block, keep, [&](auto tests) HWY_ATTR { return Axes(tests, separation, interval).along_normals(axes); });
  if (axes != CsatFilterAxes::wide) return;
  drop_kept_tests(block, keep, [&](auto tests) HWY_ATTR { return Axes(tests, separation, interval).across_edges(); });
}

void csat_features(const TestBlock& block, double separation, double t_max, CsatFilterAxes axes,
                   std::span<std::uint8_t> keep) {
  const StepInterval interval(t_max, block.control_points());
  const bool vf = block.kind() == FeatureKind::vf;
  if (block.control_points() == 2)
    (vf ? filter_block<FeatureKind::vf, 2> : filter_block<FeatureKind::ee, 2>)(block, separation, interval, axes, keep);
  if (block.control_points() == 3)
    (vf ? filter_block<FeatureKind::vf, 3> : filter_block<FeatureKind::ee, 3>)(block, separation, interval, axes, keep);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(csat_features);
}

const Options<CsatFilter::Config>& CsatFilter::options() {
  static const Options<Config> options = Options<Config>().add(
      "axes", &Config::axes,
      {{"first", CsatFilterAxes::first}, {"ends", CsatFilterAxes::ends}, {"wide", CsatFilterAxes::wide}},
      "normals at t = 0 (the paper's), at both ends, or those and in-plane axes");
  return options;
}

void CsatFilter::run(const Step& step, StageState&, unsigned, const TestBlock& block,
                     std::span<std::uint8_t> keep) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(csat_features)(block, step.separation, step.t_max, config_.axes, keep);
}

StageDescriptor<FeatureFilter> describe_csat_filter() {
  return describe_stage<FeatureFilter, CsatFilter>(
      "feature-csat", "continuous separating axis test on one feature pair (Corollaries 1 and 3)",
      Guarantee::conservative);
}

}  // namespace volccd
#endif
