// Adjacent pairs of elements that are left out touch only in their common features.
#include <volccd/culling/stars/suspect_pairs.hpp>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "culling/stars/ends_in_loop.hpp"
#include "culling/stars/jittered_block.hpp"

namespace volccd::detail {
namespace {

constexpr auto kAlways = [](Index, Index) { return true; };

void update(SuspectPairs& pairs, const Step& step, Executor& executor) {
  SerialExecutor serial;
  VertexStars stars;
  stars.update(step, serial);
  pairs.update(step, stars, executor, kAlways);
}

TEST(SuspectPairs, AnInterruptedListLeavesNothingToTheNext) {
  SerialExecutor serial;
  EndsInLoop interrupted(0);
  SuspectPairs suspects;
  const JitteredBlock large(ElementType::tetrahedron, 3, 0.6, 3), small(ElementType::tetrahedron, 1, 0.6, 3);
  EXPECT_THROW(update(suspects, large.step(), interrupted), std::runtime_error);
  update(suspects, small.step(), serial);
  for (const ElementPair pair : suspects.pairs()) EXPECT_LT(pair.b, small.topology().mesh().element_slots());
}

/// A pair with a clear star at a common vertex is never listed, nor one tetrahedron whose volume has a sign, nor two
/// with a common face and the same sign; all other pairs that no plane separates are listed once.
TEST(SuspectPairs, ListEachPairOnce) {
  SerialExecutor serial;
  for (const double amount : {0.01, 0.6}) {
    const JitteredBlock block(ElementType::tetrahedron, 3, amount, 3);
    const Mesh& mesh = block.topology().mesh();
    VertexStars stars;
    stars.update(block.step(), serial);
    SuspectPairs suspects;
    suspects.update(block.step(), stars, serial, kAlways);
    if (amount < 0.1) {
      EXPECT_TRUE(suspects.pairs().empty());
      continue;
    }
    std::vector<ElementPair> pairs(suspects.pairs().begin(), suspects.pairs().end());
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
    std::size_t listed = 0;
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b) {
        std::size_t common = 0, clear = 0;
        for (const Index v : mesh.vertices(a))
          if (const auto of_b = mesh.vertices(b); std::find(of_b.begin(), of_b.end(), v) != of_b.end())
            ++common, clear += stars.suspect(v) ? 0 : 1;
        const bool is_listed = std::binary_search(pairs.begin(), pairs.end(), ElementPair{a, b});
        const bool one_sign = stars.volume_sign(a) * stars.volume_sign(b) == 1;
        listed += is_listed ? 1 : 0;
        if (common == 0 || clear > 0 || (common >= 3 && one_sign)) {
          EXPECT_FALSE(is_listed) << a << ' ' << b;
        } else if (common >= 3) {
          EXPECT_TRUE(is_listed) << a << ' ' << b;
        }
      }
    EXPECT_EQ(listed, pairs.size());
    EXPECT_GT(listed, 100u);
  }
}

}  // namespace
}  // namespace volccd::detail
