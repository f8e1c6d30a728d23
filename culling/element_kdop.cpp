#include <volccd/culling/element_kdop.hpp>

#include <atomic>
#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/vertex_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/element_kdop.cpp"
#include <hwy/foreach_target.h>
#include <volccd/numerics/kdop_lanes-inl.hpp>

#ifndef VOLCCD_ELEMENT_KDOP_ROWS
#define VOLCCD_ELEMENT_KDOP_ROWS
namespace volccd::detail {

/// Bounds of an element at one control point.
struct alignas(64) ElementRow {
  float low[kRowAxisCount], high[kRowAxisCount];
};

/// The bounds of the elements in a step. Row c of element o is at rows[o * control_points + c].
struct ElementRows {
  static constexpr std::uint8_t kMissing = 0, kBegun = 1, kReady = 2;

  std::vector<ElementRow> rows;
  bool all_made;                       ///< otherwise rows are made when they are first asked for
  std::vector<std::uint8_t> progress;  ///< by element, unless all are made; atomic
  VertexRow half_separation;           ///< by which bounds are widened
};

}  // namespace volccd::detail
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

using AxisTag = hn::CappedTag<float, kRowAxisCount>;

/// Projections are within 2^-23 |f| of their values f in a row (VertexRow), apart from underflow; the two roundings
/// below add less than 2^-22 (|f| + separation). An overflow gives an infinite bound on one side and NaN on the other,
/// and neither separates.
template <class V>
HWY_INLINE V widening(V bound, V separation) {
  const hn::DFromV<V> tag;
  const V size = hn::Add(hn::Abs(bound), separation);
  return hn::Add(hn::Mul(size, hn::Set(tag, 0x1p-21f)), hn::Set(tag, 0x1p-120f));
}

/// Makes the rows of one element.
void bound_element(const Step& step, const VertexRow& half_separation, Index o, ElementRow* rows) {
  using Axes = KdopAxes<16, kRowAxisCount>;
  const hn::Rebind<float, Axes::Tag> narrow;
  const std::span<const Index> vertices = step.mesh().vertices(o);
  for (int c = 0; c < step.motion.control_points(); ++c)
    for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(narrow)) {
      const Axes axes(i);
      auto min = axes.project(step.motion.at(vertices[0]) + 3 * c), max = min;
      for (const Index v : vertices.subspan(1)) {
        const auto at = axes.project(step.motion.at(v) + 3 * c);
        min = hn::Min(min, at);
        max = hn::Max(max, at);
      }
      const auto low = hn::DemoteTo(narrow, min), high = hn::DemoteTo(narrow, max);
      const auto separation = hn::Load(narrow, half_separation.at + i);
      hn::Store(hn::Sub(hn::Sub(low, separation), widening(low, separation)), narrow, rows[c].low + i);
      hn::Store(hn::Add(hn::Add(high, separation), widening(high, separation)), narrow, rows[c].high + i);
    }
}

/// The rows of an element. If another worker is just making them, they are made in `own` as well.
template <std::size_t kControlPoints>
HWY_INLINE const ElementRow* rows_of(const Step& step, ElementRows& all, Index o, ElementRow (&own)[kControlPoints]) {
  const std::atomic_ref progress(all.progress[o]);
  ElementRow* rows = all.rows.data() + o * kControlPoints;
  if (all.all_made) return rows;
  std::uint8_t seen = progress.load(std::memory_order_acquire);
  if (seen == ElementRows::kReady) return rows;
  if (seen == ElementRows::kMissing &&
      progress.compare_exchange_strong(seen, ElementRows::kBegun, std::memory_order_relaxed)) {
    bound_element(step, all.half_separation, o, rows);
    progress.store(ElementRows::kReady, std::memory_order_release);
    return rows;
  }
  bound_element(step, all.half_separation, o, own);
  return own;
}

void bound_elements(const Step& step, ElementRows& all, std::size_t begin, std::size_t end) {
  const auto controls = static_cast<std::size_t>(step.motion.control_points());
  for (std::size_t o = begin; o < end; ++o)
    if (step.mesh().is_live(static_cast<Index>(o)))
      bound_element(step, all.half_separation, static_cast<Index>(o), all.rows.data() + o * controls);
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
void cull_pairs(const Step& step, ElementRows& rows, PairBatch& batch) {
  ElementRow of_a[kControlPoints], of_b[kControlPoints];
  batch.cull([&](ElementPair pair, FeatureMask&) HWY_ATTR {
    return apart<kControlPoints>(rows_of(step, rows, pair.a, of_a), rows_of(step, rows, pair.b, of_b))
               ? PairVerdict::disjoint
               : PairVerdict::keep;
  });
}

void cull_by_rows(const Step& step, ElementRows& rows, PairBatch& batch) {
  step.motion.control_points() == 2 ? cull_pairs<2>(step, rows, batch) : cull_pairs<3>(step, rows, batch);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(bound_elements);
HWY_EXPORT(cull_by_rows);
}  // namespace detail

namespace {

using namespace detail;

constexpr std::size_t kElementGrain = 512;

struct alignas(64) Worker {
  std::size_t pairs = 0;
};

struct ElementKdopState final : StageState {
  ElementRows elements;
  std::vector<Worker> workers;

  std::size_t bytes() const override { return heap_bytes(elements.rows, elements.progress, workers); }
};

}  // namespace

std::unique_ptr<StageState> ElementKdop::make_state() const { return std::make_unique<ElementKdopState>(); }

void ElementKdop::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  ElementKdopState& state = static_cast<ElementKdopState&>(stage_state);
  const std::size_t slots = step.mesh().element_slots();
  ElementRows& elements = state.elements;
  std::size_t pairs = 0;  // of the last step
  for (const Worker& worker : state.workers) pairs += worker.pairs;
  state.workers.assign(executor.workers(), {});
  elements.half_separation = row_of_distance(step.separation / 2);
  elements.all_made = pairs > step.mesh().element_count();
  elements.rows.resize(slots * static_cast<std::size_t>(step.motion.control_points()));
  elements.progress.assign(slots, ElementRows::kMissing);
  if (!elements.all_made) return;
  executor.parallel_for(slots, kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    HWY_DYNAMIC_DISPATCH(bound_elements)(step, elements, begin, end);
  });
}

void ElementKdop::run(const Step& step, StageState& stage_state, unsigned worker, PairBatch& batch) const {
  ElementKdopState& state = static_cast<ElementKdopState&>(stage_state);
  state.workers[worker].pairs += batch.size();
  HWY_DYNAMIC_DISPATCH(cull_by_rows)(step, state.elements, batch);
}

StageDescriptor<ElementCulling> describe_element_kdop() {
  return describe_stage<ElementCulling, ElementKdop>(
      "element-kdop", "bounds of both elements along fixed axes are apart at each control point",
      Guarantee::conservative);
}

}  // namespace volccd
#endif
