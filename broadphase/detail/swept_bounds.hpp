// Swept k-DOPs of vertices and elements in single precision, which all broad phases of this module use.
//
// The bound of a vertex contains its control points, and the bound of an element contains the bounds of its vertices
// (convex-hull property). Rounding: coordinates and sums of two coordinates are rounded by fl() to doubles, and then
// outward to floats. fl() is monotone; therefore intervals that overlap in exact arithmetic still overlap, although an
// end may be inside the exact interval by half an ulp. Sums of three terms and widened bounds have more than one
// rounding, which is not monotone; they are widened by a margin of 2^-51 (|x| + |y| + |z|), twice the greatest error of
// two additions. Each side is widened by half of the separation times the length of the axis. Finally all values are
// clamped to finite floats, which is monotone as well: an empty bound (+inf, -inf) overlaps nothing.
#pragma once

#include <cstddef>
#include <memory>
#include <new>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Number of axes of a k-DOP, padded to whole vector registers: 4, 8 or 16. The padding of live bounds is [0, 0].
constexpr int padded_axes(int k) { return k <= 8 ? 4 : k <= 16 ? 8 : 16; }

/// One row for each bound: width() minima, then width() maxima. Rows are aligned to their size, at most to 64 bytes.
class BoundsTable {
 public:
  static constexpr std::size_t kMaxFloats = 32;  ///< maximum number of floats in a row

  /// The contents are undefined afterwards. Allocates memory only to grow beyond the largest size so far.
  void resize(std::size_t rows, int width);
  /// The same, but keeps the first `kept` rows, and allocates a reserve for further growth if there are any.
  void grow(std::size_t rows, std::size_t kept);

  int width() const { return width_; }
  float* row(std::size_t i) { return data_.get() + i * stride(); }
  const float* row(std::size_t i) const { return data_.get() + i * stride(); }
  std::size_t bytes() const { return capacity_ * sizeof(float); }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::size_t stride() const { return 2 * static_cast<std::size_t>(width_); }

  std::unique_ptr<float[], Free> data_;
  std::size_t capacity_ = 0;
  int width_ = 8;
};

/// Computes the bounds of all vertices over the step. k as in numerics/kdop.hpp. Returns the elapsed seconds.
double bound_vertices(const Step& step, int k, Executor& executor, BoundsTable& vertices);

/// Computes the bounds of the listed elements into the same rows of `elements`, which are enlarged if necessary; gaps
/// of the list get empty bounds.
void bound_elements(const BoundsTable& vertices, const ElementList& list, Executor& executor, BoundsTable& elements);

}  // namespace volccd::detail
