#include <volccd/culling/element_kdop.hpp>

#include <vector>

#include <volccd/culling/detail/vertex_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/element_kdop.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOLCCD_ELEMENT_KDOP_ROWS
#define VOLCCD_ELEMENT_KDOP_ROWS
namespace volccd::detail {

/// Bounds of an element at one control point.
struct alignas(64) ElementRow {
  float low[kRowAxisCount], high[kRowAxisCount];
};
/// By how much a bound is widened: by `separation` (half of it, times the length of the axis) and for rounding.
struct ElementWidening {
  alignas(32) float separation[kRowAxisCount];
};

}  // namespace volccd::detail
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using AxisTag = hn::CappedTag<float, kRowAxisCount>;
using AxisLanes = hn::Vec<AxisTag>;

/// Projections are within 2^-23 |f| of their values f in a row, apart from underflow; the two roundings below add less
/// than 2^-22 (|f| + separation). An overflow gives an infinite bound on one side and NaN on the other, and neither
/// separates.
HWY_INLINE AxisLanes widening(AxisLanes bound, AxisLanes separation) {
  const AxisTag tag;
  const AxisLanes size = hn::Add(hn::Abs(bound), separation);
  return hn::Add(hn::Mul(size, hn::Set(tag, 0x1p-21f)), hn::Set(tag, 0x1p-120f));
}

/// Row c of element o is rows[o * control_points + c].
void bound_element_rows(const Step& step, const VertexRow* vertices, const ElementWidening& wide, std::size_t begin,
                        std::size_t end, ElementRow* rows) {
  const AxisTag tag;
  const auto controls = static_cast<std::size_t>(step.motion.control_points());
  for (std::size_t o = begin; o < end; ++o) {
    if (!step.takes_part(static_cast<Index>(o))) continue;
    const std::span<const Index> part = step.part(static_cast<Index>(o));
    for (std::size_t c = 0; c < controls; ++c)
      for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(tag)) {
        AxisLanes low = hn::Load(tag, vertices[part[0] * controls + c].at + i), high = low;
        for (const Index v : part.subspan(1)) {
          const AxisLanes x = hn::Load(tag, vertices[v * controls + c].at + i);
          low = hn::Min(low, x);
          high = hn::Max(high, x);
        }
        const AxisLanes separation = hn::Load(tag, wide.separation + i);
        ElementRow& row = rows[o * controls + c];
        hn::Store(hn::Sub(hn::Sub(low, separation), widening(low, separation)), tag, row.low + i);
        hn::Store(hn::Add(hn::Add(high, separation), widening(high, separation)), tag, row.high + i);
      }
  }
}

template <std::size_t kControlPoints>
HWY_INLINE bool apart(const ElementRow* a, const ElementRow* b) {
  const AxisTag tag;
  bool found = false;
  for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(tag)) {
    auto ahead = hn::Gt(hn::Load(tag, b->low + i), hn::Load(tag, a->high + i));
    auto behind = hn::Gt(hn::Load(tag, a->low + i), hn::Load(tag, b->high + i));
    for (std::size_t c = 1; c < kControlPoints; ++c) {
      ahead = hn::And(ahead, hn::Gt(hn::Load(tag, b[c].low + i), hn::Load(tag, a[c].high + i)));
      behind = hn::And(behind, hn::Gt(hn::Load(tag, a[c].low + i), hn::Load(tag, b[c].high + i)));
    }
    found = found || !hn::AllFalse(tag, hn::Or(ahead, behind));
  }
  return found;
}

template <std::size_t kControlPoints>
void cull_pairs(const ElementRow* rows, PairBatch& batch) {
  batch.cull([&](ElementPair pair, FeatureMask&) HWY_ATTR {
    return apart<kControlPoints>(rows + pair.a * kControlPoints, rows + pair.b * kControlPoints) ? PairVerdict::disjoint
                                                                                                 : PairVerdict::keep;
  });
}

void cull_by_rows(const ElementRow* rows, int control_points, PairBatch& batch) {
  control_points == 2 ? cull_pairs<2>(rows, batch) : cull_pairs<3>(rows, batch);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(bound_element_rows);
HWY_EXPORT(cull_by_rows);
}  // namespace detail

namespace {

using namespace detail;

constexpr std::size_t kElementGrain = 512;

struct ElementKdopState final : StageState {
  std::vector<VertexRow> vertices;
  std::vector<ElementRow> elements;
  const ElementSubset* subset = nullptr;

  std::size_t bytes() const override {
    return vertices.capacity() * sizeof(VertexRow) + elements.capacity() * sizeof(ElementRow);
  }
};

ElementWidening widening_for(double separation) {
  ElementWidening wide;
  for (std::size_t i = 0; i < kRowAxisCount; ++i) wide.separation[i] = float_above(separation / 2 * row_axis_length(i));
  return wide;
}

}  // namespace

std::unique_ptr<StageState> ElementKdop::make_state() const { return std::make_unique<ElementKdopState>(); }

void ElementKdop::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  ElementKdopState& state = static_cast<ElementKdopState&>(stage_state);
  const int controls = step.motion.control_points();
  state.subset = step.subset;
  project_vertices(step.motion, executor, state.vertices);
  state.elements.resize(step.mesh().element_slots() * static_cast<std::size_t>(controls));
  const ElementWidening wide = widening_for(step.separation);
  executor.parallel_for(step.mesh().element_slots(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    HWY_DYNAMIC_DISPATCH(bound_element_rows)
    (step, state.vertices.data(), wide, begin, end, state.elements.data());
  });
}

void ElementKdop::run(const Step& step, StageState& stage_state, unsigned, PairBatch& batch) const {
  const ElementKdopState& state = static_cast<const ElementKdopState&>(stage_state);
  if (step.subset != state.subset) return;
  HWY_DYNAMIC_DISPATCH(cull_by_rows)(state.elements.data(), step.motion.control_points(), batch);
}

StageDescriptor<ElementCulling> describe_element_kdop() {
  return describe_stage<ElementCulling, ElementKdop>(
      "element-kdop", "bounds of both elements along fixed axes are apart at each control point",
      Guarantee::conservative);
}

}  // namespace volccd
#endif
