#include <volccd/narrowphase/detail/moving_points.hpp>

namespace volccd::detail {

double range_scale(const TestPoints& x) {
  // A quarter of each difference: cannot overflow.
  double quarter = 0;
  for (std::size_t i = 1; i < 4; ++i)
    for (int k = 0; k < 6; ++k) quarter = std::max(quarter, std::abs(0.25 * x[i][k] - 0.25 * x[0][k]));
  if (quarter >= kLeastSize / 4 && quarter <= kGreatestSize / 4) return 1;
  if (quarter == 0) return 1;
  // Two steps where the power itself would overflow are not needed: 2^1023 lifts the smallest difference above 2^-52.
  return std::ldexp(1.0, std::clamp(-std::ilogb(quarter) - 2, -1022, 1023));
}

}  // namespace volccd::detail
