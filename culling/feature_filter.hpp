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

  /// Sets keep[i] to 0 for tests of the block that do not touch (come within step.separation) during [0, step.t_max];
  /// leaves it alone otherwise. keep.size() == block.padded_size(), multiples of 8, so that kernels need no tail;
  /// entries from block.size() on are of no account. Pre: the block is not empty.
  virtual void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   std::span<std::uint8_t> keep) const = 0;
};

}  // namespace volccd
