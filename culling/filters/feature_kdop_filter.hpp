// Feature filter: bounds of the two features along the fixed axes of a k-DOP (numerics/kdop.hpp).
#pragma once

#include <volccd/query/roles/feature_filter.hpp>

namespace volccd {

enum class KdopBounds {
  swept,    ///< k-DOPs that enclose all control points of each feature: tests their bounds for overlap
  relative  ///< compares bounds at each control point, which must be disjoint in the same order: drops all that `swept`
            ///< drops, and is not affected by common motion
};

/// Drops a test if the bounds along some axis keep the features apart by more than step.separation.
///
/// Guarantee: conservative in floating point for any finite coordinates. Along axes of one or two terms, rounding does
/// not change the result of comparisons (rounding is monotone); along other axes a gap is used only if it exceeds its
/// rounding bound (numerics/rounding.hpp). For step.t_max < 1 the motion over [0, t_max] is bounded.
class FeatureKdopFilter final : public FeatureFilter {
 public:
  enum class Axes { k6, k14, k16, k18, k24, k26 };
  struct Config {
    Axes k = Axes::k18;
    KdopBounds bounds = KdopBounds::relative;
  };
  static const Options<Config>& options();

  explicit FeatureKdopFilter(const Config& config);

  /// Relative bounds along the axes of the 16-DOP, in single precision, are compared before coordinates are gathered,
  /// unless the options exclude that.
  std::unique_ptr<StageState> make_state() const override;
  void prepare_select(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t select(const Step& step, StageState& state, unsigned worker, FeatureKind kind,
                     std::span<FeaturePair> tests) const override;
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;

 private:
  unsigned axes_;  ///< bit i: axis i of the 26-DOP
  bool selects_;   ///< whether the tests that rows drop are among those that run() drops
  KdopBounds bounds_;
};

StageDescriptor<FeatureFilter> describe_feature_kdop_filter();

}  // namespace volccd
