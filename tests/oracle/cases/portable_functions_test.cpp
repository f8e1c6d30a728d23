// The functions are correctly rounded on random arguments, and have the same bits on every processor.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/portable_functions.hpp>

namespace volccd {
namespace {

/// FNV-1a.
std::uint64_t joined(std::uint64_t hash, double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return (hash ^ bits) * 1099511628211u;
}

/// The distance of `found` from `expected`, in units of the distance between doubles.
long double error(double found, long double expected) {
  const double below = std::nextafter(found, 0), unit = std::abs(found - below);
  return std::abs(static_cast<long double>(found) - expected) / static_cast<long double>(unit);
}

TEST(PortableFunctions, AreRoundedToNearest) {
  if (std::numeric_limits<long double>::digits <= 53) GTEST_SKIP() << "long double has no more bits than double";
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(-10, 10), y = random.uniform(-10, 10);
    const long double long_x = x, long_y = y;
    EXPECT_LE(error(portable_sin(x), std::sin(long_x)), 0.501L) << x;
    EXPECT_LE(error(portable_cos(x), std::cos(long_x)), 0.501L) << x;
    EXPECT_LE(error(portable_exp(x), std::exp(long_x)), 0.501L) << x;
    EXPECT_LE(error(portable_hypot(x, y), std::sqrt(long_x * long_x + long_y * long_y)), 0.501L) << x << ' ' << y;
  }
  for (const double x : {1e6, -999999.5, 1e-8, 1e-300, 3.14159265358979, 1.5707963267948966}) {
    EXPECT_LE(error(portable_sin(x), std::sin(static_cast<long double>(x))), 0.51L) << x;
    EXPECT_LE(error(portable_cos(x), std::cos(static_cast<long double>(x))), 0.51L) << x;
  }
  EXPECT_EQ(portable_sin(0), 0);
  EXPECT_EQ(portable_cos(0), 1);
  EXPECT_EQ(portable_exp(0), 1);
  EXPECT_EQ(portable_hypot(0, 0), 0);
  EXPECT_EQ(portable_hypot(-3, 4), 5);
  EXPECT_EQ(portable_hypot(3e300, 4e300), 5e300);
  EXPECT_EQ(portable_hypot(0, 1e-320), 1e-320);
}

TEST(PortableFunctions, HaveTheSameBitsEverywhere) {
  Random random(4);
  std::uint64_t sin = 0, cos = 0, exp = 0, hypot = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(-20, 20), y = random.uniform(-20, 20);
    sin = joined(sin, portable_sin(x));
    cos = joined(cos, portable_cos(x));
    exp = joined(exp, portable_exp(x));
    hypot = joined(hypot, portable_hypot(x, y));
  }
  EXPECT_EQ(sin, 17733565228513993931u);
  EXPECT_EQ(cos, 17844326607187527151u);
  EXPECT_EQ(exp, 15848859931860555085u);
  EXPECT_EQ(hypot, 3980246558340988557u);
}

}  // namespace
}  // namespace volccd
