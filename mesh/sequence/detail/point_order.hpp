// The points of a file in the order of their ids.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/sequence/detail/layout.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Ids ascending, and the place of each point of the file among them.
class PointOrder {
 public:
  /// From the ids of the first step. Throws InputError for an id that is negative or given twice.
  explicit PointOrder(const SequenceLayout& layout);

  std::span<const std::int64_t> ids() const { return ids_; }
  std::span<const Index> slots() const { return slots_; }

  /// Throws InputError if the ids stored for the step are not those of the first.
  void check(const SequenceLayout& layout, std::size_t step);

 private:
  std::vector<std::int64_t> ids_;
  std::vector<Index> slots_;
  std::vector<std::int64_t> step_ids_;
};

}  // namespace volccd::detail
