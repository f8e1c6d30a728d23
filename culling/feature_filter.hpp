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

  /// Sets keep[i] to 0 for tests of the block whose features do not touch (do not come within step.separation) during
  /// [0, step.t_max]; does not change the other entries. keep.size() == block.padded_size() is a multiple of 8, so that
  /// kernels need no remainder loop; the entries from block.size() on are ignored. Pre: the block is not empty.
  virtual void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   std::span<std::uint8_t> keep) const = 0;
};

}  // namespace volccd
