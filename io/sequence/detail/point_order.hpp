// The order of the points of a file by their ids.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/io/sequence/detail/layout.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// The ids in ascending order, and the position of each point of the file in this order.
class PointOrder {
 public:
  /// Reads the ids of the first frame. Throws InputError for a negative or repeated id.
  explicit PointOrder(const SequenceLayout& layout);

  std::span<const std::int64_t> ids() const { return ids_; }
  std::span<const Index> slots() const { return slots_; }

  /// Throws InputError if the ids stored for the frame differ from those of the first frame.
  void check(const SequenceLayout& layout, std::size_t frame);

 private:
  std::vector<std::int64_t> ids_;
  std::vector<Index> slots_;
  std::vector<std::int64_t> frame_ids_;
};

}  // namespace volccd::detail
