// k-DOPs: bounds along k/2 fixed axes, in single precision, rounded outward.
//
// Axes, in this order (Klosowski et al. 1998; Section 3.3 of the paper uses k = 16):
//   k =  6   x y z
//   k = 14   x y z, x+y+z, x+y-z, x-y+z, x-y-z
//   k = 16   x y z, x+y, x+z, y+z, x-y, x-z
//   k = 18   those of 16, and y-z
//   k = 24   x y z, the six face diagonals of 18, x+y-z, x-y+z, x-y-z
//   k = 26   x y z, the six face diagonals of 18, the four space diagonals of 14
// Axes are not normalised: a bound along x+y is a bound on the sum of the coordinates. Widening the bounds by a
// distance d therefore adds d times the Euclidean length of the axis.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace volccd {

/// Largest float <= x, smallest float >= x. Values beyond the range of floats are rounded outward to -inf / +inf or
/// inward to the largest finite float, whichever is a valid bound. The rounding mode is not changed.
inline float float_below(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}
inline float float_above(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

/// Axes of the k-DOP as integer vectors in {-1, 0, 1}^3.
template <int K>
constexpr std::array<std::array<int, 3>, K / 2> kdop_axes() {
  static_assert(K == 6 || K == 14 || K == 16 || K == 18 || K == 24 || K == 26);
  constexpr int all[13][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, 0, 1},   {0, 1, 1}, {1, -1, 0},
                              {1, 0, -1}, {0, 1, -1}, {1, 1, -1}, {1, -1, 1}, {1, -1, -1}, {1, 1, 1}};
  constexpr int fourteen[7] = {0, 1, 2, 12, 9, 10, 11};
  std::array<std::array<int, 3>, K / 2> axes{};
  for (int i = 0; i < K / 2; ++i) {
    const int from = K == 14 ? fourteen[i] : i;
    for (int c = 0; c < 3; ++c) axes[static_cast<std::size_t>(i)][static_cast<std::size_t>(c)] = all[from][c];
  }
  return axes;
}

/// Number of non-zero components: 1, 2 or 3. Its square root is the length of the axis.
constexpr int axis_terms(const std::array<int, 3>& axis) {
  return axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
}

}  // namespace volccd
