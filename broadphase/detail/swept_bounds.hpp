// Swept k-DOPs of vertices and elements in floats, as all broad phases here use them.
//
// The bound of a vertex holds its control points, that of an element the bounds of its vertices (convex-hull property).
// Rounding: coordinates and sums of two of them are mapped by fl() in double and then outward to float. fl() is
// monotone, so that intervals which meet in exact arithmetic still meet after it, though an end may lie inside the
// exact one by half an ulp. Sums of three terms, and any bound that is widened, are not monotone in one rounding and
// get a margin of 2^-51 (|x| + |y| + |z|), twice what two additions can lose. Each side is widened by half of
// separation times the axis's length. At last everything is clamped to finite floats, which is monotone too: an empty
// bound (+inf, -inf) then overlaps nothing, however far a live one reaches.
#pragma once

#include <cstddef>
#include <memory>
#include <new>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Axes of a k-DOP padded to whole vector registers: 4, 8 or 16. Padding is [0, 0] in live bounds.
constexpr int padded_axes(int k) { return k <= 8 ? 4 : k <= 16 ? 8 : 16; }

/// A row for each bound: width() minima, then width() maxima; rows are aligned to their size, or 64 bytes.
class BoundsTable {
 public:
  static constexpr std::size_t kMostFloats = 32;  ///< in a row

  /// Contents are undefined afterwards. Allocates only to grow beyond any size before.
  void resize(std::size_t rows, int width);
  /// The same, keeping the first `kept` rows.
  void grow(std::size_t rows, std::size_t kept);

  int width() const { return width_; }
  float* row(std::size_t i) { return data_.get() + i * stride(); }
  const float* row(std::size_t i) const { return data_.get() + i * stride(); }
  std::size_t bytes() const { return capacity_ * sizeof(float); }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete(p, std::align_val_t{64}); }
  };
  std::size_t stride() const { return 2 * static_cast<std::size_t>(width_); }

  std::unique_ptr<float[], Free> data_;
  std::size_t capacity_ = 0;
  int width_ = 8;
};

/// Bounds of all vertices over the step. k as in query/kdop.hpp. Returns the seconds that it took.
double bound_vertices(const Step& step, int k, Executor& executor, BoundsTable& vertices);

/// Bounds of the listed elements [begin, end) into the same rows of `elements`; gaps of the list get empty bounds.
void bound_elements(const BoundsTable& vertices, const ElementList& list, std::size_t begin, std::size_t end,
                    BoundsTable& elements);
/// The same for the whole list, in parallel; makes `elements` large enough.
void bound_elements(const BoundsTable& vertices, const ElementList& list, Executor& executor, BoundsTable& elements);

}  // namespace volccd::detail
