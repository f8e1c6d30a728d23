// Static feature assignment: Section 5.2, Algorithm 4.
#pragma once

#include <volccd/culling/feature_culling.hpp>
#include <volccd/culling/o_set.hpp>

namespace volccd {

/// Each feature belongs to the first element that has it, in the order of slots (Algorithm 4's greedy choice). A feature pair
/// {a,b} is tested by the pair of elements that they belong to, which may be adjacent, or one element: complete, and each
/// test exactly once, on all pairs, adjacent ones and self pairs included.
///
/// Unsound with an O-Set, as Section 5.2 says: then adjacent pairs are skipped, and pairs that belong to them but are
/// covered by other, non-adjacent elements are in no O-Set.
class StaticAssignment final : public FeatureCulling {
 public:
  struct Config {
    OSetKind oset = OSetKind::none;
  };
  static const Options<Config>& options();

  explicit StaticAssignment(const Config& config) : config_(config) {}

  bool needs_adjacent_pairs() const override { return true; }
  std::string unsound() const override;
  bool exactly_once() const override { return true; }
  std::unique_ptr<StageState> make_state() const override;
  void update(const Step& step, StageState& state) const override;
  void tests(const Step& step, const StageState& state, const PairBatch& batch, TestBatch& out) const override;
  std::size_t orphan_blocks(const StageState&) const override { return 0; }
  void orphans(const Step&, const StageState&, std::size_t, TestBatch&) const override {}

 private:
  Config config_;
};

StageDescriptor<FeatureCulling> describe_static_assignment();

}  // namespace volccd
