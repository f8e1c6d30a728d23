// Feature filter: the tests that belong to a rank.
#pragma once

#include <volccd/distributed/regions.hpp>
#include <volccd/query/roles/feature_filter.hpp>

namespace volccd::distributed {

/// Keeps a test if its reference point is in the region: the lower corner of the common part of the boxes of its two
/// features, each around all control points of the whole step (also for step.t_max < 1) and enlarged by half the
/// separation (box.hpp). Of regions that divide space, exactly one keeps a test, so that ranks perform it once in all
/// (the reference-point method of Dittrich and Seeger, 2000).
///
/// Candidates are collected without this filter (FeatureFilter::leaves_tests_to_others): in later steps their reference
/// points are elsewhere.
///
/// As the last filter of a pipeline it has the fewest tests to look at. Its state has 24 bytes a vertex. Guarantee:
/// exact, because the result depends on comparisons of given doubles alone and, with a separation, on one formula that
/// all ranks evaluate.
class RegionFilter final : public FeatureFilter {
 public:
  /// The region must outlive the filter, and may change between steps.
  explicit RegionFilter(const Region& region) : region_(region) {}

  bool leaves_tests_to_others() const override { return true; }
  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;

 private:
  const Region& region_;
};

/// Its name is "region". The region must outlive all filters that the descriptor makes.
StageDescriptor<FeatureFilter> describe_region_filter(const Region& region);

}  // namespace volccd::distributed
