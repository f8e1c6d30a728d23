// Element culling: bounds of both elements along the eight fixed axes of the 16-DOP (numerics/kdop.hpp).
#pragma once

#include <volccd/query/roles/element_culling.hpp>

namespace volccd {

/// Drops a pair if, along some axis, the bounds of the two elements at each control point are more than step.separation
/// apart, and in the same order. In contrast to swept bounds, these are not affected by common motion, so that the
/// stage drops most pairs of a broad phase for a fraction of the time of `csat`.
///
/// Bounds are in single precision. run() makes those of an element when a pair contains it, and each worker keeps the
/// last ones, in at most 2 MiB for linear motion. No table of all elements is made.
///
/// Guarantee: conservative in floating point for any finite coordinates: bounds are widened by more than all rounding
/// errors. They hold over [0, 1] for every t_max.
class ElementKdop final : public ElementCulling {
 public:
  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override;
};

StageDescriptor<ElementCulling> describe_element_kdop();

}  // namespace volccd
