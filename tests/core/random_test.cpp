#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>

namespace volccd {
namespace {

// Published values of SplitMix64 for this seed, so that the sequence is the same on every platform.
TEST(Random, IsSplitMix64) {
  Random random(1234567);
  for (const std::uint64_t expected :
       {6457827717110365317u, 3203168211198807973u, 9817491932198370423u, 4593380528125082431u, 16408922859458223821u})
    EXPECT_EQ(random.next(), expected);
}

TEST(Random, RangesHold) {
  Random random(1);
  bool low_half = false, high_half = false;
  for (int i = 0; i < 10000; ++i) {
    EXPECT_LT(random.below(7), 7u);
    const double u = random.uniform();
    ASSERT_TRUE(u >= 0 && u < 1);
    (u < 0.5 ? low_half : high_half) = true;
    const double v = random.uniform(-2, 3);
    ASSERT_TRUE(v >= -2 && v <= 3);
  }
  EXPECT_TRUE(low_half && high_half);
}

TEST(Random, ShufflePermutes) {
  std::vector<int> values(100);
  std::iota(values.begin(), values.end(), 0);
  const std::vector<int> sorted = values;
  Random random(3);
  random.shuffle(values);
  EXPECT_NE(values, sorted);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, sorted);
}

TEST(Random, HashOfIdsDependsOnTheirOrder) {
  EXPECT_NE(hash_ids(1, 2), hash_ids(2, 1));
  EXPECT_NE(hash_ids(0, 0), 0u);
}

}  // namespace
}  // namespace volccd
