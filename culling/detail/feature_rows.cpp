#include <volccd/culling/detail/feature_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/feature_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOLCCD_FEATURE_ROWS_SEPARATION
#define VOLCCD_FEATURE_ROWS_SEPARATION
namespace volccd::detail {

/// The separation along each axis, times the length of the axis and a factor for the rounding of gap and bound.
struct RowSeparation {
  alignas(32) float at[kRowAxisCount];
};

}  // namespace volccd::detail
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kRowAxisCount>;
using RowLanes = hn::Vec<RowTag>;
using RowMask = hn::Mask<RowTag>;

struct RowRange {
  RowLanes low, high;

  HWY_INLINE void add(RowLanes x) {
    low = hn::Min(low, x);
    high = hn::Max(high, x);
  }
};

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
HWY_INLINE bool features_apart(const VertexRow* const (&rows)[4], const RowSeparation& separation) {
  const RowTag tag;
  bool found = false;
  for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(tag)) {
    RowMask ahead = hn::FirstN(tag, kRowAxisCount), behind = ahead;
    for (std::size_t c = 0; c < kControlPoints; ++c) {
      const auto load = [&](std::size_t v) HWY_ATTR { return hn::Load(tag, rows[v][c].at + i); };
      RowRange first{load(0), load(0)}, second{load(2), load(2)};
      kKind == FeatureKind::vf ? second.add(load(1)) : first.add(load(1));
      second.add(load(3));
      ahead = hn::And(ahead, below<kSeparation>(first.high, second.low, separation.at + i));
      behind = hn::And(behind, below<kSeparation>(second.high, first.low, separation.at + i));
    }
    found = found || !hn::AllFalse(tag, hn::Or(ahead, behind));
  }
  return found;
}

template <bool kSeparation, std::size_t kControlPoints, FeatureKind kKind>
std::size_t select_apart(const VertexRow* rows, const Features& features, const RowSeparation& separation,
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
std::size_t select_of_kind(const VertexRow* rows, const Features& features, FeatureKind kind,
                           const RowSeparation& separation, std::span<FeaturePair> tests) {
  return kind == FeatureKind::vf
             ? select_apart<kSeparation, kControlPoints, FeatureKind::vf>(rows, features, separation, tests)
             : select_apart<kSeparation, kControlPoints, FeatureKind::ee>(rows, features, separation, tests);
}

std::size_t select_by_rows(const VertexRow* rows, const Step& step, FeatureKind kind, const RowSeparation& separation,
                           std::span<FeaturePair> tests) {
  const bool linear = step.motion.control_points() == 2;
  if (step.separation == 0)
    return (linear ? select_of_kind<false, 2> : select_of_kind<false, 3>)(rows, step.features(), kind, separation,
                                                                          tests);
  return (linear ? select_of_kind<true, 2> : select_of_kind<true, 3>)(rows, step.features(), kind, separation, tests);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(select_by_rows);

void FeatureRows::update(const Step& step, Executor& executor) { project_vertices(step.motion, executor, rows_); }

std::size_t FeatureRows::select(const Step& step, FeatureKind kind, std::span<FeaturePair> tests) const {
  RowSeparation separation;
  for (std::size_t i = 0; i < kRowAxisCount; ++i)
    separation.at[i] = float_above(step.separation * row_axis_length(i) * (1 + 0x1p-20));
  return HWY_DYNAMIC_DISPATCH(select_by_rows)(rows_.data(), step, kind, separation, tests);
}

}  // namespace volccd::detail
#endif
