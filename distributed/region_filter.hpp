// Feature filter: the tests that belong to a rank.
#pragma once

#include <volccd/query/roles/feature_filter.hpp>

namespace volccd::distributed {

/// Keeps a test if its reference point is in the region of the step, for the control points of the whole step (also
/// for step.t_max < 1). Of regions that divide space, exactly one keeps a test, so that ranks perform it once in all
/// (the reference-point method of Dittrich and Seeger, 2000).
///
/// As the last filter of a pipeline it has the fewest tests to look at. Its state has 24 bytes a vertex. Guarantee:
/// exact, because the result depends on comparisons of given doubles alone and, with a separation, on one formula that
/// all ranks evaluate.
class RegionFilter final : public FeatureFilter {
 public:
  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;
};

/// Its name is "region".
StageDescriptor<FeatureFilter> describe_region_filter();

}  // namespace volccd::distributed
