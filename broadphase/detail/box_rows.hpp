// Swept boxes in doubles, and one of them against many: the kernel of `brute-force`.
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Structure of arrays: six rows (minima along x, y, z, then maxima) of size() boxes and some padding.
class BoxRows {
 public:
  static constexpr std::size_t kPadding = 8;

  /// Exact boxes of the control points, the maxima increased by the separation and rounded upward: one side is widened,
  /// so that a pair passes if its boxes come within the separation.
  void update(const Step& step, const ElementList& list, Executor& executor);

  std::size_t size() const { return size_; }
  const double* low(std::size_t axis) const { return values_.data() + axis * stride(); }
  const double* high(std::size_t axis) const { return values_.data() + (3 + axis) * stride(); }

  /// Writes the positions p of boxes in [begin, end) that overlap box i to `out`, ascending; returns their number.
  /// `out` has room for end - begin + kPadding.
  std::size_t overlapping(std::size_t i, std::size_t begin, std::size_t end, Index* out) const;

  std::size_t bytes() const { return values_.capacity() * sizeof(double); }

 private:
  std::size_t stride() const { return size_ + kPadding; }

  std::size_t size_ = 0;
  std::vector<double> values_;
};

}  // namespace volccd::detail
