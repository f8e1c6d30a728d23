#include <volccd/culling/feature_kdop_filter.hpp>

#include <array>
#include <utility>

#include <volccd/mesh/kdop.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/feature_kdop_filter.cpp"
#include <hwy/foreach_target.h>
#include <volccd/culling/detail/filter_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// x + y + z of the signed coordinates that the axis takes, in that order: the rounding bounds count on it.
template <int kX, int kY, int kZ>
HWY_INLINE Lanes along(const Lanes3& p) {
  static_assert(kX == 1 || (kX == 0 && (kY == 1 || (kY == 0 && kZ == 1))), "first term positive");
  Lanes sum = kX != 0 ? p.x : kY != 0 ? p.y : p.z;
  if constexpr (kX != 0 && kY != 0) sum = kY > 0 ? hn::Add(sum, p.y) : hn::Sub(sum, p.y);
  if constexpr ((kX != 0 || kY != 0) && kZ != 0) sum = kZ > 0 ? hn::Add(sum, p.z) : hn::Sub(sum, p.z);
  return sum;
}

template <FeatureKind kKind, int kControlPoints>
class Bounds {
 public:
  HWY_INLINE Bounds(const FeatureBlock& block, double separation, const Part& part, bool swept, std::size_t i)
      : separation_(separation * kLengthSlack), swept_(swept), exact_(separation == 0 && part.levels == 0) {
    Lanes3 greatest = abs(load(block, 0, 0, i));
    for (int v = 0; v < 4; ++v) {
      for (int c = 0; c < kControlPoints; ++c) {
        points_[v][c] = load(block, c, v, i);
        greatest = max(greatest, abs(points_[v][c]));
      }
      restrict_to<kControlPoints>(part, points_[v]);
    }
    const Lanes sum = add3(greatest.x, greatest.y, greatest.z);
    rounding_ = hn::Add(hn::Mul(trusted(sum), same(sum_error_factor(part.levels))), same(kGapUnderflow));
  }

  template <int kX, int kY, int kZ>
  HWY_INLINE LaneMask apart() const {
    constexpr int terms = kX * kX + kY * kY + kZ * kZ;
    constexpr double lengths[4] = {0, 1, 0x1.6a09e667f3bcdp+0, 0x1.bb67ae8584cabp+0};  // square roots, rounded up
    const Lanes gap = this->template gap<kX, kY, kZ>();
    // Times 0: no bound is needed, but an infinite one stays an obstacle (as NaN).
    const Lanes bound = exact_ && terms < 3 ? hn::Mul(rounding_, hn::Zero(Tag()))
                                            : hn::Add(rounding_, same(separation_ * lengths[terms]));
    return hn::Gt(gap, bound);
  }

 private:
  struct Range {
    Lanes low, high;
  };
  static HWY_INLINE Range joined(const Range& a, const Range& b) {
    return {hn::Min(a.low, b.low), hn::Max(a.high, b.high)};
  }
  static HWY_INLINE Lanes between(const Range& a, const Range& b) {
    return hn::Max(hn::Sub(b.low, a.high), hn::Sub(a.low, b.high));
  }

  template <int kX, int kY, int kZ>
  HWY_INLINE Lanes gap() const {
    Range first[kControlPoints], second[kControlPoints];
    for (int c = 0; c < kControlPoints; ++c) {
      Lanes p[4];
      for (int v = 0; v < 4; ++v) p[v] = along<kX, kY, kZ>(points_[v][c]);
      constexpr bool vf = kKind == FeatureKind::vf;
      first[c] = vf ? Range{p[0], p[0]} : Range{hn::Min(p[0], p[1]), hn::Max(p[0], p[1])};
      second[c] = {hn::Min(p[2], p[3]), hn::Max(p[2], p[3])};
      if (vf) second[c] = joined(second[c], {p[1], p[1]});
    }
    if (swept_) {
      for (int c = 1; c < kControlPoints; ++c) {
        first[0] = joined(first[0], first[c]);
        second[0] = joined(second[0], second[c]);
      }
      return between(first[0], second[0]);
    }
    Lanes ahead = hn::Sub(second[0].low, first[0].high), behind = hn::Sub(first[0].low, second[0].high);
    for (int c = 1; c < kControlPoints; ++c) {
      ahead = hn::Min(ahead, hn::Sub(second[c].low, first[c].high));
      behind = hn::Min(behind, hn::Sub(first[c].low, second[c].high));
    }
    return hn::Max(ahead, behind);
  }

  Lanes3 points_[4][kControlPoints];
  Lanes rounding_;
  double separation_;
  bool swept_, exact_;
};

template <int K, FeatureKind kKind, int kControlPoints, std::size_t... kAxis>
HWY_INLINE LaneMask apart(const Bounds<kKind, kControlPoints>& bounds, std::index_sequence<kAxis...>) {
  constexpr auto axes = kdop_axes<K>();
  LaneMask mask = hn::FirstN(Tag(), 0);
  const auto all = [&](LaneMask more) {
    mask = hn::Or(mask, more);
    return hn::AllTrue(Tag(), mask);
  };
  (void)(all(bounds.template apart<axes[kAxis][0], axes[kAxis][1], axes[kAxis][2]>()) || ...);
  return mask;
}

struct Job {
  const FeatureBlock& block;
  double separation;
  Part part;
  bool swept;
  std::span<std::uint8_t> keep;
};

template <int K, FeatureKind kKind, int kControlPoints>
void filter_block(const Job& job) {
  for (std::size_t i = 0; i < job.block.size(); i += hn::Lanes(Tag())) {
    const Bounds<kKind, kControlPoints> bounds(job.block, job.separation, job.part, job.swept, i);
    drop(apart<K>(bounds, std::make_index_sequence<K / 2>()), i, job.keep);
  }
}

template <int K>
void filter_any(const Job& job) {
  const bool vf = job.block.kind() == FeatureKind::vf;
  if (job.block.control_points() == 2)
    (vf ? filter_block<K, FeatureKind::vf, 2> : filter_block<K, FeatureKind::ee, 2>)(job);
  if (job.block.control_points() == 3)
    (vf ? filter_block<K, FeatureKind::vf, 3> : filter_block<K, FeatureKind::ee, 3>)(job);
}

void feature_kdop(const FeatureBlock& block, double separation, double t_max, const FeatureKdopFilter::Config& config,
                  std::span<std::uint8_t> keep) {
  const Job job{block, separation, Part(t_max, block.control_points()), config.bounds == KdopBounds::swept, keep};
  switch (config.k) {
    case FeatureKdopFilter::Axes::k6: return filter_any<6>(job);
    case FeatureKdopFilter::Axes::k14: return filter_any<14>(job);
    case FeatureKdopFilter::Axes::k16: return filter_any<16>(job);
    case FeatureKdopFilter::Axes::k18: return filter_any<18>(job);
    case FeatureKdopFilter::Axes::k24: return filter_any<24>(job);
    case FeatureKdopFilter::Axes::k26: return filter_any<26>(job);
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(feature_kdop);
}

const Options<FeatureKdopFilter::Config>& FeatureKdopFilter::options() {
  static const Options<Config> options = [] {
    Options<Config> o;
    o.add("k", &Config::k,
          {{"6", Axes::k6},
           {"14", Axes::k14},
           {"16", Axes::k16},
           {"18", Axes::k18},
           {"24", Axes::k24},
           {"26", Axes::k26}},
          "twice the number of axes");
    o.add("bounds", &Config::bounds, {{"swept", KdopBounds::swept}, {"relative", KdopBounds::relative}},
          "over all control points, or apart at each of them");
    return o;
  }();
  return options;
}

void FeatureKdopFilter::filter(const Step& step, const FeatureBlock& block, std::span<std::uint8_t> keep) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(feature_kdop)(block, step.separation, step.t_max, config_, keep);
}

StageDescriptor<FeatureFilter> describe_feature_kdop_filter() {
  return describe_stage<FeatureFilter, FeatureKdopFilter>(
      "feature-kdop", "bounds of both features along fixed axes do not overlap", Guarantee::conservative);
}

}  // namespace volccd
#endif
