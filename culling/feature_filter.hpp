// The feature-filter strategy: drops single VF and EE tests before the narrow phase.
#pragma once

#include <cstdint>
#include <span>

#include <volccd/core/stage.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {

/// Stateless; concurrent calls allowed.
class FeatureFilter {
 public:
  virtual ~FeatureFilter() = default;

  /// Sets keep[i] to 0 for tests of the block that do not touch (come within step.separation) during [0, step.t_max];
  /// leaves it alone otherwise. keep.size() == block.padded_size(), multiples of 8, so that kernels need no tail; entries
  /// from block.size() on are of no account.
  virtual void filter(const Step& step, const TestBlock& block, std::span<std::uint8_t> keep) const = 0;
};

}  // namespace volccd
