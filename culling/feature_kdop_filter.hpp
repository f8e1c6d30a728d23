// Feature filter: bounds of the two features along the fixed axes of a k-DOP (query/kdop.hpp).
#pragma once

#include <volccd/culling/feature_filter.hpp>

namespace volccd {

enum class KdopBounds {
  swept,    ///< k-DOPs that enclose each feature's control points: bounds that do not overlap
  relative  ///< bounds apart, on the same side, at each control point: drops all that `swept` drops, and common motion
};

/// Drops a test when some axis keeps the features apart by more than step.separation.
///
/// Guarantee: conservative in floating point for any finite coordinates. Along axes of one or two terms comparisons are
/// as good as exact (rounding is monotone); elsewhere a gap counts beyond its rounding bound only (query/rounding.hpp).
/// For step.t_max < 1 the motion over [0, t_max] is bounded.
class FeatureKdopFilter final : public FeatureFilter {
 public:
  enum class Axes { k6, k14, k16, k18, k24, k26 };
  struct Config {
    Axes k = Axes::k18;
    KdopBounds bounds = KdopBounds::relative;
  };
  static const Options<Config>& options();

  explicit FeatureKdopFilter(const Config& config);

  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;

 private:
  unsigned axes_;  ///< bit i: axis i of the 26-DOP
  KdopBounds bounds_;
};

StageDescriptor<FeatureFilter> describe_feature_kdop_filter();

}  // namespace volccd
