#include <volccd/culling/filters/feature_kdop_filter.hpp>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/vertex_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/filters/feature_kdop_filter.cpp"
#include <hwy/foreach_target.h>
#include <volccd/query/block_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Sum x + y + z of the signed coordinates of the axis, in this order, which the rounding bounds assume.
template <int kX, int kY, int kZ>
HWY_INLINE Lanes along(const Lanes3& p) {
  static_assert(kX == 1 || (kX == 0 && (kY == 1 || (kY == 0 && kZ == 1))), "first term positive");
  Lanes sum = kX != 0 ? p.x : kY != 0 ? p.y : p.z;
  if constexpr (kX != 0 && kY != 0) sum = kY > 0 ? hn::Add(sum, p.y) : hn::Sub(sum, p.y);
  if constexpr ((kX != 0 || kY != 0) && kZ != 0) sum = kZ > 0 ? hn::Add(sum, p.z) : hn::Sub(sum, p.z);
  return sum;
}

struct Job {
  double separation;
  StepInterval interval;
  bool swept;
  unsigned axes;  ///< bit i: axis i of the 26-DOP; the axes of every k are a subset of these
};
constexpr auto kAxes = kdop_axes<26>();
constexpr unsigned kCoordinateAxes = 0x7, kExactAxes = 0x1ff;  ///< axes of one term; axes of one or two terms

/// For the whole step without a separation, and axes of one or two terms: if rounded sums of two coordinates differ,
/// the exact sums differ in the same order. The sums are compared, not subtracted, because subtraction could give NaN
/// after an overflow.
template <FeatureKind kKind, int kControlPoints>
struct ExactBounds {
  template <std::size_t kAxis, std::size_t kDistance>
  static HWY_INLINE LaneMask apart(Columns<kDistance> tests) {
    LaneMask ahead = hn::FirstN(Tag(), 0), behind = ahead;
    for (int c = 0; c < kControlPoints; ++c) {
      Lanes p[4];
      for (int v = 0; v < 4; ++v) p[v] = along<kAxes[kAxis][0], kAxes[kAxis][1], kAxes[kAxis][2]>(load(tests, c, v));
      const Lanes low = hn::Min(p[2], p[3]), high = hn::Max(p[2], p[3]);
      constexpr bool vf = kKind == FeatureKind::vf;
      const LaneMask above = hn::Gt(vf ? hn::Min(low, p[1]) : low, vf ? p[0] : hn::Max(p[0], p[1]));
      const LaneMask below = hn::Lt(vf ? hn::Max(high, p[1]) : high, vf ? p[0] : hn::Min(p[0], p[1]));
      ahead = c == 0 ? above : hn::And(ahead, above);
      behind = c == 0 ? below : hn::And(behind, below);
    }
    return hn::Or(ahead, behind);
  }

  /// The axes kFirst + 0, 1, .. that are in `axes`.
  template <std::size_t kFirst, std::size_t kDistance, std::size_t... kAxis>
  static HWY_INLINE LaneMask apart(Columns<kDistance> tests, unsigned axes, std::index_sequence<kAxis...>) {
    LaneMask mask = hn::FirstN(Tag(), 0);
    const auto join = [&](LaneMask more) HWY_ATTR { mask = hn::Or(mask, more); };
    ((axes >> (kFirst + kAxis) & 1 ? join(apart<kFirst + kAxis>(tests)) : void()), ...);
    return mask;
  }
};

/// For all cases: with a separation, for an interval of the step, over all control points, and for axes of three terms.
template <FeatureKind kKind, int kControlPoints>
class Bounds {
 public:
  HWY_INLINE Bounds(BlockColumns tests, const Job& job)
      : separation_(job.separation * kLengthSlack),
        swept_(job.swept),
        exact_(job.separation == 0 && job.interval.levels == 0) {
    Lanes3 greatest = abs(load(tests, 0, 0));
    for (int v = 0; v < 4; ++v) {
      for (int c = 0; c < kControlPoints; ++c) {
        points_[v][c] = load(tests, c, v);
        greatest = max(greatest, abs(points_[v][c]));
      }
      restrict_to<kControlPoints>(job.interval, points_[v]);
    }
    const Lanes sum = add3(greatest.x, greatest.y, greatest.z);
    rounding_ =
        hn::Add(hn::Mul(trusted(sum), broadcast(sum_error_factor(job.interval.levels))), broadcast(kGapUnderflow));
  }

  template <int kX, int kY, int kZ>
  HWY_INLINE LaneMask apart() const {
    constexpr int terms = kX * kX + kY * kY + kZ * kZ;
    constexpr double lengths[4] = {0, 1, 0x1.6a09e667f3bcdp+0, 0x1.bb67ae8584cabp+0};  // square roots, rounded upward
    const Lanes gap = this->template gap<kX, kY, kZ>();
    // Multiplied by 0: no bound is needed, but an infinite bound must prevent a separation, which NaN does.
    const Lanes bound = exact_ && terms < 3 ? hn::Mul(rounding_, hn::Zero(Tag()))
                                            : hn::Add(rounding_, broadcast(separation_ * lengths[terms]));
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

template <FeatureKind kKind, int kControlPoints, std::size_t... kAxis>
HWY_INLINE LaneMask apart(const Bounds<kKind, kControlPoints>& bounds, unsigned axes, std::index_sequence<kAxis...>) {
  LaneMask mask = hn::FirstN(Tag(), 0);
  const auto joins = [&](LaneMask more) HWY_ATTR {
    mask = hn::Or(mask, more);
    return hn::AllTrue(Tag(), mask);
  };
  (void)((((axes >> kAxis & 1) && joins(bounds.template apart<kAxes[kAxis][0], kAxes[kAxis][1], kAxes[kAxis][2]>()))) ||
         ...);
  return mask;
}

template <FeatureKind kKind, int kControlPoints>
void filter_block(Job job, const TestBlock& block, std::span<std::uint8_t> keep) {
  if (!job.swept && job.separation == 0 && job.interval.levels == 0) {
    using Exact = ExactBounds<kKind, kControlPoints>;
    drop_tests(block, keep, [&](BlockColumns tests) HWY_ATTR {
      return Exact::template apart<0>(tests, job.axes, std::make_index_sequence<3>());
    });
    if ((job.axes & kExactAxes) != kCoordinateAxes)
      drop_kept_tests(block, keep, [&](Columns<8> tests) HWY_ATTR {
        return Exact::template apart<3>(tests, job.axes, std::make_index_sequence<6>());
      });
    job.axes &= ~kExactAxes;
  }
  if (job.axes != 0)
    drop_tests(block, keep, [&](BlockColumns tests) HWY_ATTR {
      return apart(Bounds<kKind, kControlPoints>(tests, job), job.axes, std::make_index_sequence<13>());
    });
}

void feature_kdop(const TestBlock& block, double separation, double t_max, unsigned axes, KdopBounds bounds,
                  std::span<std::uint8_t> keep) {
  const Job job{separation, StepInterval(t_max, block.control_points()), bounds == KdopBounds::swept, axes};
  const bool vf = block.kind() == FeatureKind::vf;
  if (block.control_points() == 2)
    (vf ? filter_block<FeatureKind::vf, 2> : filter_block<FeatureKind::ee, 2>)(job, block, keep);
  else
    (vf ? filter_block<FeatureKind::vf, 3> : filter_block<FeatureKind::ee, 3>)(job, block, keep);
}

// Selection by rows: a test is dropped if the projections of the two features on an axis are apart at each control
// point, in the same order, by more than the separation.

using RowTag = hn::CappedTag<float, kRowAxisCount>;
using RowLanes = hn::Vec<RowTag>;
using RowMask = hn::Mask<RowTag>;

/// Lanes in which `from` is certainly below `to`, by more than the separation. Without a separation the order of
/// rounded values is enough; with one, values have errors below 2^-23 of their magnitudes.
template <bool kSeparation>
HWY_INLINE RowMask below(RowLanes from, RowLanes to, const float* separation) {
  if constexpr (!kSeparation) return hn::Lt(from, to);
  const RowTag tag;
  const RowLanes size = hn::Add(hn::Abs(from), hn::Abs(to));
  const RowLanes error = hn::Add(hn::Mul(size, hn::Set(tag, 0x1p-21f)), hn::Set(tag, 0x1p-120f));
  return hn::Gt(hn::Sub(to, from), hn::Add(hn::Load(tag, separation), error));
}

template <bool kSeparation, std::size_t kControlPoints, FeatureKind kKind>
HWY_INLINE bool features_apart(const VertexRow* const (&rows)[4], const VertexRow& separation) {
  const RowTag tag;
  bool found = false;
  for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(tag)) {
    RowMask ahead = hn::FirstN(tag, kRowAxisCount), behind = ahead;
    for (std::size_t c = 0; c < kControlPoints; ++c) {
      const auto load = [&](std::size_t v) HWY_ATTR { return hn::Load(tag, rows[v][c].at + i); };
      const RowLanes p0 = load(0), p1 = load(1), low = hn::Min(load(2), load(3)), high = hn::Max(load(2), load(3));
      constexpr bool vf = kKind == FeatureKind::vf;
      ahead =
          hn::And(ahead, below<kSeparation>(vf ? p0 : hn::Max(p0, p1), vf ? hn::Min(low, p1) : low, separation.at + i));
      behind = hn::And(behind,
                       below<kSeparation>(vf ? hn::Max(high, p1) : high, vf ? p0 : hn::Min(p0, p1), separation.at + i));
    }
    found = found || !hn::AllFalse(tag, hn::Or(ahead, behind));
  }
  return found;
}

template <bool kSeparation, std::size_t kControlPoints, FeatureKind kKind>
std::size_t select_apart(const VertexRow* rows, const Features& features, const VertexRow& separation,
                         std::span<FeaturePair> tests) {
  const auto row = [&](Index v) { return rows + v * kControlPoints; };
  std::size_t kept = 0;
  for (const FeaturePair test : tests) {
    const VertexRow* of[4];
    if constexpr (kKind == FeatureKind::vf) {
      const auto& triangle = features.triangle(test.b);
      of[0] = row(test.a), of[1] = row(triangle[0]), of[2] = row(triangle[1]), of[3] = row(triangle[2]);
    } else {
      const auto &a = features.edge(test.a), &b = features.edge(test.b);
      of[0] = row(a[0]), of[1] = row(a[1]), of[2] = row(b[0]), of[3] = row(b[1]);
    }
    tests[kept] = test;
    kept += features_apart<kSeparation, kControlPoints, kKind>(of, separation) ? 0 : 1;
  }
  return kept;
}

template <bool kSeparation, std::size_t kControlPoints>
std::size_t select_of_kind(const VertexRow* rows, const Step& step, FeatureKind kind, const VertexRow& separation,
                           std::span<FeaturePair> tests) {
  return (kind == FeatureKind::vf
              ? select_apart<kSeparation, kControlPoints, FeatureKind::vf>
              : select_apart<kSeparation, kControlPoints, FeatureKind::ee>)(rows, step.features(), separation, tests);
}

std::size_t select_by_rows(const VertexRow* rows, const Step& step, FeatureKind kind, const VertexRow& separation,
                           std::span<FeaturePair> tests) {
  const bool linear = step.motion.control_points() == 2;
  if (step.separation == 0)
    return (linear ? select_of_kind<false, 2> : select_of_kind<false, 3>)(rows, step, kind, separation, tests);
  return (linear ? select_of_kind<true, 2> : select_of_kind<true, 3>)(rows, step, kind, separation, tests);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(feature_kdop);
HWY_EXPORT(select_by_rows);

namespace {

template <int K>
constexpr unsigned among_all() {
  constexpr auto all = kdop_axes<26>();
  unsigned axes = 0;
  for (const auto& axis : kdop_axes<K>()) axes |= 1u << (std::find(all.begin(), all.end(), axis) - all.begin());
  return axes;
}

/// By FeatureKdopFilter::Axes.
constexpr unsigned kAxesOf[] = {among_all<6>(),  among_all<14>(), among_all<16>(),
                                among_all<18>(), among_all<24>(), among_all<26>()};

struct FeatureKdopState final : StageState {
  std::vector<VertexRow> rows;
  std::size_t bytes() const override { return heap_bytes(rows); }
};

}  // namespace
}  // namespace detail

const Options<FeatureKdopFilter::Config>& FeatureKdopFilter::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("k", &Config::k,
               {{"6", Axes::k6},
                {"14", Axes::k14},
                {"16", Axes::k16},
                {"18", Axes::k18},
                {"24", Axes::k24},
                {"26", Axes::k26}},
               "twice the number of axes")
          .add("bounds", &Config::bounds, {{"swept", KdopBounds::swept}, {"relative", KdopBounds::relative}},
               "over all control points, or apart at each of them");
  return options;
}

FeatureKdopFilter::FeatureKdopFilter(const Config& config)
    : axes_(detail::kAxesOf[static_cast<std::size_t>(config.k)]),
      selects_(config.bounds == KdopBounds::relative && (axes_ & detail::among_all<16>()) == detail::among_all<16>()),
      bounds_(config.bounds) {}

std::unique_ptr<StageState> FeatureKdopFilter::make_state() const {
  return std::make_unique<detail::FeatureKdopState>();
}

void FeatureKdopFilter::prepare_select(const Step& step, StageState& state, Executor& executor) const {
  if (selects_) detail::project_vertices(step.motion, executor, static_cast<detail::FeatureKdopState&>(state).rows);
}

std::size_t FeatureKdopFilter::select(const Step& step, StageState& state, unsigned, FeatureKind kind,
                                      std::span<FeaturePair> tests) const {
  if (!selects_) return tests.size();
  using namespace detail;
  const VertexRow separation = row_of_distance(step.separation * (1 + 0x1p-20));  // for the rounding of gap and bound
  const VertexRow* const rows = static_cast<FeatureKdopState&>(state).rows.data();
  return HWY_DYNAMIC_DISPATCH(select_by_rows)(rows, step, kind, separation, tests);
}

void FeatureKdopFilter::run(const Step& step, StageState&, unsigned, const TestBlock& block,
                            std::span<std::uint8_t> keep) const {
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(feature_kdop)(block, step.separation, step.t_max, axes_, bounds_, keep);
}

StageDescriptor<FeatureFilter> describe_feature_kdop_filter() {
  return describe_stage<FeatureFilter, FeatureKdopFilter>(
      "feature-kdop", "bounds of both features along fixed axes do not overlap", Guarantee::conservative);
}

}  // namespace volccd
#endif
