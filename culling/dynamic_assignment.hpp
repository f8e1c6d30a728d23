// Dynamic feature assignment: Section 5.2, Algorithm 5, with the O-Set of Section 5.1.
#pragma once

#include <volccd/culling/feature_culling.hpp>
#include <volccd/culling/o_set.hpp>

namespace volccd {

/// The owner of a feature pair {a,b} is the first pair of non-adjacent elements in inc(a) x inc(b), elements by ascending
/// slot; an EE pair is put in the order of its edge slots first, or it would have no owner or two. A feature pair is tested
/// by its owner alone; those without one are the O-Set. So every test comes out exactly once (with the minimal O-Set; the
/// literal one repeats some), and adjacent element pairs need not be looked at.
///
/// Nearly always the first elements of inc(a) and inc(b) are not adjacent and decide at once.
class DynamicAssignment final : public FeatureCulling {
 public:
  struct Config {
    OSetKind oset = OSetKind::minimal;
  };
  static const Options<Config>& options();

  explicit DynamicAssignment(const Config& config) : config_(config) {}

  bool needs_adjacent_pairs() const override { return false; }
  std::string unsound() const override;
  bool exactly_once() const override { return config_.oset == OSetKind::minimal; }
  std::unique_ptr<StageState> make_state() const override;
  void update(const Step& step, StageState& state) const override;
  /// Pairs of adjacent elements in the batch own nothing and give no tests.
  void tests(const Step& step, const StageState& state, const PairBatch& batch, TestBatch& out) const override;
  std::size_t orphan_blocks(const StageState& state) const override;
  void orphans(const Step& step, const StageState& state, std::size_t block, TestBatch& out) const override;

 private:
  Config config_;
};

StageDescriptor<FeatureCulling> describe_dynamic_assignment();

}  // namespace volccd
