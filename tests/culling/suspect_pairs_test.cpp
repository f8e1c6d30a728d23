// Adjacent simplices that the flood leaves out touch only in their common features.
#include <volccd/culling/detail/suspect_pairs.hpp>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>


#include "culling/ends_in_loop.hpp"
#include "culling/jittered_block.hpp"

namespace volccd::detail {
namespace {

StarClasses classes_of(const Step& step, Executor& executor) {
  StarTable stars;
  StarClasses classes;
  classes.update(step, stars, stars.update(step.topology, executor), executor);
  return classes;
}

TEST(SuspectPairs, AnInterruptedListLeavesNothingToTheNext) {
  SerialExecutor serial;
  EndsInLoop interrupted(0);
  SuspectPairs suspects;
  const JitteredBlock large(ElementType::tetrahedron, 3, 0.6, 3), small(ElementType::tetrahedron, 1, 0.6, 3);
  EXPECT_THROW(suspects.update(large.step(), classes_of(large.step(), serial), interrupted), std::runtime_error);
  suspects.update(small.step(), classes_of(small.step(), serial), serial);
  for (const ElementPair pair : suspects.pairs()) EXPECT_LT(pair.b, small.topology().mesh().element_slots());
}

/// A change of the topology that was announced to an interrupted step takes effect in the next step.
TEST(StarClasses, AnInterruptedStepIsBegunAnew) {
  SerialExecutor serial;
  const auto suspects = [&](bool interrupted) {
    StarTable stars;
    StarClasses classes;
    for (const int n : {3, 2}) {
      const JitteredBlock block(ElementType::tetrahedron, n, 0.25, 5);
      TopologyDelta::Extent changed = stars.update(block.topology(), serial);
      if (n == 2 && interrupted) {
        EndsInLoop executor(0);
        EXPECT_THROW(classes.update(block.step(), stars, changed, executor), std::runtime_error);
        changed = TopologyDelta::Extent::none;
      }
      classes.update(block.step(), stars, changed, serial);
    }
    return classes.suspects();
  };
  EXPECT_EQ(suspects(true), suspects(false));
}

/// A pair with a clear star at a common vertex is never listed; all other pairs of a star are listed once.
TEST(SuspectPairs, ListEachPairOnce) {
  SerialExecutor serial;
  for (const double amount : {0.01, 0.6}) {
    const JitteredBlock block(ElementType::tetrahedron, 3, amount, 3);
    const StarClasses classes = classes_of(block.step(), serial);
    SuspectPairs suspects;
    suspects.update(block.step(), classes, serial);
    if (amount < 0.1) {
      EXPECT_TRUE(suspects.pairs().empty());
      continue;
    }
    EXPECT_GT(suspects.pairs().size(), 100u);
    std::vector<ElementPair> pairs(suspects.pairs().begin(), suspects.pairs().end());
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
    for (const ElementPair pair : pairs) {
      EXPECT_LE(pair.a, pair.b);
      EXPECT_NE(classes.common_suspects(block.topology(), pair.a, pair.b), 0u);
      EXPECT_TRUE(suspects.contains(pair.b, pair.a));
    }
  }
}

}  // namespace
}  // namespace volccd::detail
