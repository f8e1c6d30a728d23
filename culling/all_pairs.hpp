// Feature culling that culls nothing: all tests of every element pair (what NavCCD and HashCCD do, Sections 3.4 and 6.1).
#pragma once

#include <volccd/culling/feature_culling.hpp>
#include <volccd/culling/o_set.hpp>

namespace volccd {

/// Tests of an element pair (a,b): each vertex of a against each triangle of b, each vertex of b against each triangle of a,
/// each edge of a against each edge of b; of a pair (o,o): each vertex against each triangle, each pair of edges. Without
/// those that share a vertex, and each distinct feature pair once per element pair: adjacent elements share features, and
/// what both have would otherwise come out twice.
///
/// The same feature pair comes out of many element pairs. Complete without an O-Set on all pairs, adjacent ones and self pairs
/// included; with an O-Set on the non-adjacent pairs alone (an ablation: what O-Sets do without assignment).
class AllPairs final : public FeatureCulling {
 public:
  struct Config {
    OSetKind oset = OSetKind::none;
  };
  static const Options<Config>& options();

  explicit AllPairs(const Config& config) : config_(config) {}

  bool needs_adjacent_pairs() const override { return config_.oset == OSetKind::none; }
  bool exactly_once() const override { return false; }
  std::unique_ptr<StageState> make_state() const override;
  void update(const Step& step, StageState& state) const override;
  void tests(const Step& step, const StageState& state, const PairBatch& batch, TestBatch& out) const override;
  std::size_t orphan_blocks(const StageState& state) const override;
  void orphans(const Step& step, const StageState& state, std::size_t block, TestBatch& out) const override;

 private:
  Config config_;
};

StageDescriptor<FeatureCulling> describe_all_pairs();

}  // namespace volccd
