#include <volccd/culling/filters/coplanarity_filter.hpp>

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/filters/coplanarity_filter.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/determinant-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Upper bound, over the whole step, on the area that relates a distance to the determinant: the product of the lengths
/// of two sides of the triangle (VF) or of both edges (EE).
template <int kControlPoints>
HWY_INLINE Lanes greatest_area(bool vf, BlockColumns tests) {
  Lanes first = hn::Zero(Tag()), second = first;
  for (int c = 0; c < kControlPoints; ++c) {
    first = hn::Max(first, length(sub(load(tests, c, vf ? 2 : 1), load(tests, c, vf ? 1 : 0))));
    second = hn::Max(second, length(sub(load(tests, c, 3), load(tests, c, vf ? 1 : 2))));
  }
  // The product of an infinite and a zero length would be NaN, which a maximum may discard.
  const Lanes min = broadcast(kMinExtent);
  return hn::Max(hn::Mul(hn::Max(first, min), hn::Max(second, min)), broadcast(kMinSquare));
}

template <int kControlPoints>
HWY_INLINE LaneMask never_coplanar(bool vf, BlockColumns tests, double separation, const StepInterval& interval) {
  const Differences<kControlPoints> e(tests, interval);
  DeterminantError error(e.extent, determinant_error_factor(kControlPoints, interval.levels));
  if (separation > 0) {
    const Lanes area = greatest_area<kControlPoints>(vf, tests);
    error.scaled = hn::Add(error.scaled, hn::Mul(broadcast(separation * kAreaSlack), area));
  }
  const DeterminantSigns signs(Determinant<kControlPoints>(e.at), error);
  return hn::Or(signs.positive, signs.negative);
}

template <int kControlPoints>
void filter_block(const TestBlock& block, double separation, const StepInterval& interval,
                  std::span<std::uint8_t> keep) {
  drop_tests(block, keep, [&](auto tests) HWY_ATTR {
    return never_coplanar<kControlPoints>(block.kind() == FeatureKind::vf, tests, separation, interval);
  });
}

void coplanarity(const TestBlock& block, double separation, double t_max, std::span<std::uint8_t> keep) {
  const StepInterval interval(t_max, block.control_points());
  if (block.control_points() == 2) filter_block<2>(block, separation, interval, keep);
  if (block.control_points() == 3) filter_block<3>(block, separation, interval, keep);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(coplanarity);
}

void CoplanarityFilter::run(const Step& step, StageState&, unsigned, const TestBlock& block,
                            std::span<std::uint8_t> keep) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(coplanarity)(block, step.separation, step.t_max, keep);
}

StageDescriptor<FeatureFilter> describe_coplanarity_filter() {
  return describe_stage<FeatureFilter, CoplanarityFilter>(
      "coplanarity", "four points that are never coplanar (Tang et al. 2010)", Guarantee::conservative);
}

}  // namespace volccd
#endif
