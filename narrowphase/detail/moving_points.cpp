#include <volccd/narrowphase/detail/moving_points.hpp>

namespace volccd::detail {

CurvedPoints curved_points(const TestPoints& x, double scale) {
  CurvedPoints points;
  points.size = 0;
  Differences* const controls[] = {&points.start, &points.middle, &points.end};
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const double d = scaled_difference(x[i + 1][3 * c + k], x[0][3 * c + k], scale);
        (*controls[c])[i][k] = d;
        points.size = std::max(points.size, std::abs(d));
      }
  return points;
}

double range_scale(const TestPoints& x, int control_points) {
  // A quarter of each difference: cannot overflow.
  double quarter = 0;
  for (std::size_t i = 1; i < 4; ++i)
    for (int k = 0; k < 3 * control_points; ++k) quarter = std::max(quarter, std::abs(0.25 * x[i][k] - 0.25 * x[0][k]));
  if (quarter >= kLeastSize / 4 && quarter <= kGreatestSize / 4) return 1;
  if (quarter == 0) return 1;
  // Two steps where the power itself would overflow are not needed: 2^1023 lifts the smallest difference above 2^-52.
  return std::ldexp(1.0, std::clamp(-std::ilogb(quarter) - 2, -1022, 1023));
}

}  // namespace volccd::detail
