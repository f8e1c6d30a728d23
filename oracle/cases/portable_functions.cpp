#include <volccd/oracle/cases/portable_functions.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/numerics/double_double.hpp>

namespace volccd {

namespace {

using detail::DoubleDouble, detail::exact_product, detail::exact_sum;

/// a / n for a small integer n.
DoubleDouble divided(DoubleDouble a, double n) {
  const double high = a.high / n;
  const DoubleDouble product = exact_product(high, n);
  return exact_sum(high, ((a.high - product.high) - product.low + a.low) / n);
}

/// A constant to 160 bits.
struct Constant {
  double high, middle, low;
};
constexpr Constant kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};
constexpr Constant kLn2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56, 0x1.7b57a079a1934p-111};

struct Reduced {
  double k;        ///< an integer
  DoubleDouble r;  ///< x - k c
};

/// k is the integer nearest to x / c.
Reduced reduced(double x, const Constant& c) {
  const double k = std::nearbyint(x / c.high);
  const DoubleDouble main = exact_product(k, c.high);
  DoubleDouble r = exact_sum(x, -main.high) + DoubleDouble{-main.low, 0};
  const DoubleDouble middle = exact_product(k, c.middle);
  r = r + DoubleDouble{-middle.high, -middle.low};
  return {k, r + DoubleDouble{-k * c.low, 0}};
}

/// The sum of x^n / n! for n = first, first + 2, ... with alternating signs, |x| < 0.8; first is 0 or 1.
DoubleDouble alternating_series(DoubleDouble x, int first) {
  const DoubleDouble square = x * x;
  DoubleDouble sum{1, 0};
  for (int n = 30 + first; n > first; n -= 2)
    sum = DoubleDouble{1, 0} - divided(square * sum, static_cast<double>(n * (n - 1)));
  return first == 0 ? sum : x * sum;
}

/// The sine of the angle `turns` quarter turns ahead of x.
double sine(double x, int turns) {
  const Reduced angle = reduced(x, kHalfPi);
  const auto quadrant = static_cast<int>(std::fmod(angle.k, 4.0)) + turns + 4;
  const double value = alternating_series(angle.r, quadrant % 2 == 0 ? 1 : 0).high;
  return quadrant % 4 < 2 ? value : -value;
}

}  // namespace

double portable_sin(double x) { return sine(x, 0); }
double portable_cos(double x) { return sine(x, 1); }

double portable_exp(double x) {
  const Reduced power = reduced(x, kLn2);
  DoubleDouble sum{1, 0};
  for (int n = 28; n > 0; --n) sum = DoubleDouble{1, 0} + divided(power.r * sum, n);
  return std::ldexp(sum.high, static_cast<int>(power.k));
}

double portable_hypot(double x, double y) {
  const double greatest = std::max(std::abs(x), std::abs(y));
  if (greatest == 0) return 0;
  int exponent = 0;  // without which squares neither overflow nor lose bits that matter
  std::frexp(greatest, &exponent);
  const double a = std::ldexp(x, -exponent), b = std::ldexp(y, -exponent);
  const DoubleDouble square = exact_product(a, a) + exact_product(b, b);
  const double root = std::sqrt(square.high);
  const DoubleDouble product = exact_product(root, root);
  return std::ldexp(root + ((square.high - product.high) - product.low + square.low) / (2 * root), exponent);
}

}  // namespace volccd
