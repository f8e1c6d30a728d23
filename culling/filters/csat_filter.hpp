// Feature filter: continuous separating axis test of one VF or EE pair (Section 4, Corollaries 1 and 3).
#pragma once

#include <volccd/query/roles/feature_filter.hpp>

namespace volccd {

enum class CsatFilterAxes {
  first,  ///< as in the paper: VF: normal of the triangle at t = 0; EE: cross product of the edges at t = 0
  ends,   ///< also the normal or cross product at the last control point
  wide    ///< also, at t = 0, the normals of each edge within the plane of the triangle (or of both edges)
};

/// Drops a test if the projections of the two features onto an axis are disjoint at each control point, in the same
/// order, by more than step.separation.
///
/// The paper needs 4 and 5 dot products because those at t = 0 are equal along n0. In floating point they are not
/// equal, since n0 is rounded; therefore all are computed here, relative to the first vertex (6 per test for two
/// control points).
///
/// Guarantee: conservative in floating point for any finite coordinates: a gap is used only if it exceeds its rounding
/// bound (numerics/rounding.hpp). For step.t_max < 1 the motion over [0, t_max] is tested.
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
