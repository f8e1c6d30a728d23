// No feature culling: every pair of features of every element pair (NavCCD, HashCCD; Section 6.1).
#pragma once

#include <volccd/culling/feature_culling.hpp>
#include <volccd/culling/o_set.hpp>

namespace volccd {

/// The tests of an element pair {a,b} are its distinct feature pairs without a common vertex: vertices of one with triangles of
/// the other, edges of one with edges of the other. For non-adjacent elements these are the n_v^a n_f^b + n_v^b n_f^a and
/// n_e^a n_e^b tests of Section 4.4. Adjacent elements may give one pair twice (both features belonging to both
/// elements): it is tested once. An element with itself: each vertex with each triangle that it is not in, each unordered
/// pair of edges. The same feature pair comes again from other element pairs.
class AllPairs final : public FeatureCulling {
 public:
  struct Config {
    /// none: adjacent pairs and self pairs are tested like others. Else only non-adjacent pairs are, and the O-Set.
    OSetKind oset = OSetKind::none;
  };
  static const Options<Config>& options();

  explicit AllPairs(const Config& config = {}) : config_(config) {}

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

/// `all-pairs`
StageDescriptor<FeatureCulling> describe_all_pairs();

}  // namespace volccd
