// heap_bytes() adds up what vectors, vectors of vectors and objects with bytes() have allocated.
#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/heap_bytes.hpp>

namespace volccd {
namespace {

struct Counted {
  std::size_t bytes() const { return 100; }
};

TEST(HeapBytes, AddsUpMembers) {
  std::vector<double> numbers;
  numbers.reserve(10);
  std::vector<std::array<std::uint32_t, 3>> tuples(2);
  EXPECT_EQ(heap_bytes(numbers), 10 * sizeof(double));
  EXPECT_EQ(heap_bytes(numbers, tuples, Counted()), numbers.capacity() * 8 + tuples.capacity() * 12 + 100);
  EXPECT_EQ(heap_bytes(), 0u);
}

TEST(HeapBytes, CountsElementsThatAllocate) {
  const std::vector<std::vector<char>> lists = {std::vector<char>(5), std::vector<char>(7)};
  EXPECT_EQ(heap_bytes(lists), 2 * sizeof(lists[0]) + 5 + 7);
  const std::vector<Counted> objects(3);
  EXPECT_EQ(heap_bytes(objects), 3 * sizeof(Counted) + 300);
  const std::vector<std::vector<Counted>> nested = {std::vector<Counted>(1)};
  EXPECT_EQ(heap_bytes(nested), sizeof(nested[0]) + sizeof(Counted) + 100);
}

}  // namespace
}  // namespace volccd
