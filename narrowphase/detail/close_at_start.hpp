// Tests whose features are within the separation when the step begins: a vector kernel finds their closest points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::detail {

/// Nearly all contacts of a solver that asks in each substep are of this kind: features that stay close to each other.
/// Stored on the stack, without allocation.
class CloseAtStart {
 public:
  /// Examines the tests with keep[i] != 0. Two or three control points. Pre: separation > 0, keep.size() >=
  /// block.padded_size().
  void find(const TestBlock& block, double separation, std::span<const std::uint8_t> keep);

  /// True only if the features of test i are certainly within the separation at t = 0. False also for some of which
  /// inclusion_search() finds this: those that touch, and those that it has to scale. The answer does not depend on the
  /// other tests, and has the same bits for every vector length.
  bool contains(std::size_t i) const { return rows_.close[i] != 0; }
  /// The closest points at t = 0, as closest_points() defines them. Pre: contains(i).
  ScaledClosestPoints closest(std::size_t i) const {
    return {.points = {.weights = {rows_.weights[0][i], rows_.weights[1][i], rows_.weights[2][i], rows_.weights[3][i]},
                       .separation = {rows_.separation[0][i], rows_.separation[1][i], rows_.separation[2][i]},
                       .squared_distance = rows_.square[i]},
            .size = rows_.size[i],
            .scale = 1};
  }

  /// What the kernel stores; `close` as 1.0 or 0.0.
  struct Rows {
    using Row = double[TestBlock::kCapacity];
    alignas(64) Row weights[4], separation[3], square, size, close;
  };

 private:
  Rows rows_;
};

}  // namespace volccd::detail
