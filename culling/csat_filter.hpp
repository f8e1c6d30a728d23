// Feature filter: continuous separating axis test on one VF or EE pair (Section 4, Corollaries 1 and 3).
#pragma once

#include <volccd/culling/feature_filter.hpp>

namespace volccd {

enum class CsatFilterAxes {
  first,  ///< the paper's: VF: the triangle's normal at t = 0; EE: the cross product of the edges at t = 0
  ends,   ///< those, and the same at the last control point
  wide    ///< those of `ends`, and at t = 0 the lines across each edge in the plane of the triangle (of both edges)
};

/// Drops a test when the projections of the two features along an axis stay disjoint, on the same side, at each control
/// point, by more than step.separation.
///
/// The paper's 4 and 5 dot products count those at t = 0 once, as they are equal along n0. They are not in floating
/// point, n0 being rounded: all are computed here, relative to the first vertex (6 a test for two control points).
///
/// Guarantee: conservative in floating point for any finite coordinates: a gap counts beyond its rounding bound only
/// (query/rounding.hpp). For step.t_max < 1 the motion over [0, t_max] is tested.
class CsatFilter final : public FeatureFilter {
 public:
  struct Config {
    CsatFilterAxes axes = CsatFilterAxes::wide;
  };
  static const Options<Config>& options();

  explicit CsatFilter(const Config& config) : config_(config) {}

  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;

 private:
  Config config_;
};

StageDescriptor<FeatureFilter> describe_csat_filter();

}  // namespace volccd
