#include <volccd/culling/element_kdop.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
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

/// The bounds of the elements that a worker looked up last in a step, in a direct-mapped cache: broad phases emit pairs
/// of elements that are near each other one after the other.
class ElementRows {
 public:
  void clear(std::size_t slots, std::size_t control_points) {
    control_points_ = control_points;
    elements_.assign(std::bit_ceil(std::clamp<std::size_t>(slots, 1, kMaxEntries)), kNone);
    rows_.resize(elements_.size() * control_points);
  }

  bool share_entry(Index a, Index b) const { return entry(a) == entry(b); }
  /// The rows of element o, by control point, and whether they must be made. Valid until the entry of o is looked up.
  std::pair<ElementRow*, bool> find(Index o) {
    return {rows_.data() + entry(o) * control_points_, std::exchange(elements_[entry(o)], o) != o};
  }

  std::size_t bytes() const { return heap_bytes(elements_, rows_); }

 private:
  static constexpr std::size_t kMaxEntries = std::size_t{1} << 14;
  std::size_t entry(Index o) const { return o & (elements_.size() - 1); }

  std::size_t control_points_ = 2;
  std::vector<Index> elements_;  ///< by entry
  std::vector<ElementRow> rows_;
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

HWY_INLINE const ElementRow* rows_of(const Step& step, const VertexRow& half_separation, Index o, ElementRows& rows) {
  const auto [found, missing] = rows.find(o);
  if (missing) bound_element(step, half_separation, o, found);
  return found;
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
void cull_pairs(const Step& step, const VertexRow& half_separation, ElementRows& rows, PairBatch& batch) {
  ElementRow other[kControlPoints];
  batch.cull([&](ElementPair pair, FeatureMask&) HWY_ATTR {
    const ElementRow *const a = rows_of(step, half_separation, pair.a, rows), *b = other;
    if (rows.share_entry(pair.a, pair.b))
      bound_element(step, half_separation, pair.b, other);
    else
      b = rows_of(step, half_separation, pair.b, rows);
    return apart<kControlPoints>(a, b) ? PairVerdict::disjoint : PairVerdict::keep;
  });
}

void cull_by_rows(const Step& step, const VertexRow& half_separation, ElementRows& rows, PairBatch& batch) {
  (step.motion.control_points() == 2 ? cull_pairs<2> : cull_pairs<3>)(step, half_separation, rows, batch);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {
namespace detail {
HWY_EXPORT(cull_by_rows);
}  // namespace detail

namespace {

using namespace detail;

struct alignas(64) Worker {
  ElementRows rows;
  std::size_t bytes() const { return heap_bytes(rows); }
};

struct ElementKdopState final : StageState {
  VertexRow half_separation;  ///< by which bounds are widened
  std::vector<Worker> workers;

  std::size_t bytes() const override { return heap_bytes(workers); }
};

}  // namespace

std::unique_ptr<StageState> ElementKdop::make_state() const { return std::make_unique<ElementKdopState>(); }

void ElementKdop::prepare(const Step& step, StageState& stage_state, Executor& executor) const {
  ElementKdopState& state = static_cast<ElementKdopState&>(stage_state);
  state.half_separation = row_of_distance(step.separation / 2);
  state.workers.resize(std::max<std::size_t>(state.workers.size(), executor.workers()));
  for (Worker& worker : state.workers)
    worker.rows.clear(step.mesh().element_slots(), static_cast<std::size_t>(step.motion.control_points()));
}

void ElementKdop::run(const Step& step, StageState& stage_state, unsigned worker, PairBatch& batch) const {
  ElementKdopState& state = static_cast<ElementKdopState&>(stage_state);
  HWY_DYNAMIC_DISPATCH(cull_by_rows)(step, state.half_separation, state.workers[worker].rows, batch);
}

StageDescriptor<ElementCulling> describe_element_kdop() {
  return describe_stage<ElementCulling, ElementKdop>(
      "element-kdop", "bounds of both elements along fixed axes are apart at each control point",
      Guarantee::conservative);
}

}  // namespace volccd
#endif
