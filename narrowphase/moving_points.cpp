#include <volccd/narrowphase/moving_points.hpp>

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
  const auto greatest_difference = [&](double scale) {
    double greatest = 0;
    for (std::size_t i = 1; i < 4; ++i)
      for (int k = 0; k < 3 * control_points; ++k)
        greatest = std::max(greatest, std::abs(scale * x[i][k] - scale * x[0][k]));
    return greatest;
  };
  const double size = greatest_difference(1);
  if (size >= kMinSize && size <= kGreatestSize) return 1;
  if (size == 0) return 1;
  // A quarter of a difference cannot overflow, but a quarter of the smallest differences would underflow.
  const int exponent = size < kMinSize ? std::ilogb(size) : std::ilogb(greatest_difference(0.25)) + 2;
  // If the power itself would overflow, 2^1023 is sufficient: it scales the smallest difference to 2^-51.
  return std::ldexp(1.0, std::clamp(-exponent, -1022, 1023));
}

}  // namespace volccd::detail
