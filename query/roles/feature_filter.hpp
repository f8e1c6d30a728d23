// The feature-filter strategy: drops single VF and EE tests before the narrow phase.
#pragma once

#include <cstdint>
#include <span>

#include <volccd/query/stage.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {

class FeatureFilter : public Stage {
 public:
  static constexpr const char* kRole = "feature-filter";

  /// Prepares select(), after prepare(), in steps in which it is called: on the first filter, where tests are so many
  /// that a table of all vertices pays.
  virtual void prepare_select(const Step& step, StageState& state, Executor& executor) const {
    (void)step, (void)state, (void)executor;
  }

  /// Drops tests before their coordinates are gathered: by the same rule as run(), which sees only those that are left.
  /// Moves these to the front of `tests`, in their order, and returns their number; the entries behind are unspecified.
  virtual std::size_t select(const Step& step, StageState& state, unsigned worker, FeatureKind kind,
                             std::span<FeaturePair> tests) const {
    (void)step, (void)state, (void)worker, (void)kind;
    return tests.size();
  }

  /// Sets keep[i] to 0 for tests of the block whose features do not touch (do not come within step.separation) during
  /// [0, step.t_max], or that are not asked for; does not change the other entries. keep.size() == block.padded_size()
  /// is a multiple of 8, so that kernels need no remainder loop; the entries from block.size() on are ignored. Pre: the
  /// block is not empty.
  virtual void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   std::span<std::uint8_t> keep) const = 0;
};

}  // namespace volccd
