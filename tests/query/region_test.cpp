#include <volccd/query/region.hpp>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>

namespace volccd {
namespace {

/// With 64 bits for the significand, the sums below are exact: both numbers have 53, and their exponents differ by less
/// than 11.
TEST(MotionBox, EnlargedBoundsAreRoundedOutward) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double x = (i % 2 ? 1 : -1) * random.uniform(0.25, 1), d = random.uniform(0.25, 1);
    const long double low = static_cast<long double>(x) - d / 2, high = static_cast<long double>(x) + d / 2;
    ASSERT_LE(enlarged_low(x, d), low);
    ASSERT_GE(enlarged_high(x, d), high);
    ASSERT_EQ(enlarged_low(x, 0), x);
    ASSERT_EQ(enlarged_high(x, 0), x);
  }
}

TEST(MotionBox, HalfOfTheSmallestSeparationIsNotLost) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  EXPECT_LE(enlarged_low(tiny, tiny), enlarged_high(0, tiny));
}

TEST(MotionBox, EnlargedBoundsAreMonotone) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform(-1, 1), y = i % 2 ? std::nextafter(x, 2) : random.uniform(-1, 1);
    const double d = i % 3 ? random.uniform(0, 1) : 1e3;
    ASSERT_EQ(std::max(enlarged_low(x, d), enlarged_low(y, d)), enlarged_low(std::max(x, y), d));
    ASSERT_EQ(std::max(enlarged_high(x, d), enlarged_high(y, d)), enlarged_high(std::max(x, y), d));
  }
}

}  // namespace
}  // namespace volccd
