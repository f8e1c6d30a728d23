// Swept boxes in doubles, and the kernel of `brute-force`, which tests one box against many.
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A structure of arrays: six rows (minima along x, y, z, then maxima), each with size() boxes and some padding.
class BoxRows {
 public:
  static constexpr std::size_t kPadding = 8;

  /// Computes the exact boxes of the control points. The separation is added to the maxima, rounded upward. Only one
  /// side is widened, so that two boxes overlap if they come within the separation.
  void update(const Step& step, const ElementList& list, Executor& executor);

  std::size_t size() const { return size_; }
  const double* low(std::size_t axis) const { return values_.data() + axis * stride(); }
  const double* high(std::size_t axis) const { return values_.data() + (3 + axis) * stride(); }

  /// Writes the positions p in [begin, end) of the boxes that overlap box i to `out`, in ascending order, and returns
  /// their number. `out` must have space for end - begin + kPadding entries.
  std::size_t overlapping(std::size_t i, std::size_t begin, std::size_t end, Index* out) const;

  std::size_t bytes() const { return heap_bytes(values_); }

 private:
  std::size_t stride() const { return size_ + kPadding; }

  std::size_t size_ = 0;
  std::vector<double> values_;
};

}  // namespace volccd::detail
