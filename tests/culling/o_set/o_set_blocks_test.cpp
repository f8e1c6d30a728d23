// The list of blocks of an O-Set: rows of any length, and pairs that later ones replace.
#include <volccd/culling/o_set/detail/o_set_blocks.hpp>

#include <set>
#include <utility>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

class OSetBlocksTest : public ::testing::Test {
 protected:
  using Owner = detail::OSetBlocks::Owner;

  OSetBlocksTest() : topology_(block(ElementType::tetrahedron, 6, 6, 6).mesh()) { blocks_.start_over(features()); }
  const Features& features() const { return topology_.features(); }

  void write(Owner kind, Index owner, Index first, Index end) {
    detail::OSetBlocks::Part part;
    detail::OSetBlocks::Writer rows(part, kind);
    rows.begin_row(owner);
    for (Index i = first; i < end; ++i) rows.add(i);
    rows.flush();
    blocks_.append(std::move(part));
  }
  std::set<std::pair<Index, Index>> pairs(FeatureKind kind) const {
    TestBatch batch;
    for (std::size_t b = 0; b < blocks_.size(); ++b) blocks_.append(b, batch);
    std::set<std::pair<Index, Index>> set;
    for (const FeaturePair p : kind == FeatureKind::vf ? batch.vf : batch.ee)
      EXPECT_TRUE(set.insert({p.a, p.b}).second);
    return set;
  }

  Topology topology_;
  detail::OSetBlocks blocks_;
};

TEST_F(OSetBlocksTest, LongRowsGoOn) {
  const Index n = 3 * detail::OSetBlocks::kBlockPairs + 5;
  write(Owner::vertex, 7, 0, n);
  EXPECT_EQ(blocks_.size(), 4u);
  EXPECT_EQ(pairs(FeatureKind::vf).size(), n);
  write(Owner::edge, 7, 9, 9);
  EXPECT_EQ(blocks_.size(), 4u) << "empty rows leave nothing";
}

TEST_F(OSetBlocksTest, RenewalsVoidEarlierPairs) {
  write(Owner::vertex, 1, 10, 13);
  write(Owner::triangle, 20, 2, 4);
  write(Owner::edge, 5, 3, 5);
  blocks_.settle();
  blocks_.next_epoch(features());
  blocks_.renew(Owner::triangle, 11);
  blocks_.renew(Owner::vertex, 2);
  blocks_.renew(Owner::edge, 4);
  EXPECT_TRUE(blocks_.is_new(Owner::vertex, 2) && !blocks_.is_new(Owner::vertex, 1));
  EXPECT_TRUE(blocks_.is_new(Owner::edge, 4) && !blocks_.is_new(Owner::edge, 5));
  EXPECT_EQ(pairs(FeatureKind::vf), (std::set<std::pair<Index, Index>>{{1, 10}, {1, 12}, {3, 20}}));
  EXPECT_EQ(pairs(FeatureKind::ee), (std::set<std::pair<Index, Index>>{{3, 5}}));
  blocks_.next_epoch(features());
  EXPECT_FALSE(blocks_.is_new(Owner::vertex, 2));
  write(Owner::vertex, 1, 11, 12);
  write(Owner::edge, 5, 4, 5);
  const std::set<std::pair<Index, Index>> vf{{1, 10}, {1, 11}, {1, 12}, {3, 20}}, ee{{3, 5}, {4, 5}};
  EXPECT_EQ(pairs(FeatureKind::vf), vf);
  EXPECT_EQ(pairs(FeatureKind::ee), ee);
  EXPECT_EQ(blocks_.counts(), (OSetCounts{vf.size(), ee.size()}));
}

/// Epochs are numbered with 16 bits.
TEST_F(OSetBlocksTest, EpochsNeverRunOut) {
  write(Owner::vertex, 1, 10, 12);
  blocks_.settle();
  blocks_.next_epoch(features());
  blocks_.renew(Owner::triangle, 11);
  write(Owner::triangle, 11, 3, 4);
  for (int i = 0; i < 70'000; ++i) blocks_.next_epoch(features());
  EXPECT_EQ(pairs(FeatureKind::vf), (std::set<std::pair<Index, Index>>{{1, 10}, {3, 11}}));
  blocks_.renew(Owner::vertex, 1);
  EXPECT_TRUE(blocks_.is_new(Owner::vertex, 1));
  write(Owner::vertex, 1, 12, 13);
  for (int i = 0; i < 70'000; ++i) blocks_.next_epoch(features());
  EXPECT_EQ(pairs(FeatureKind::vf), (std::set<std::pair<Index, Index>>{{1, 12}, {3, 11}}));
  blocks_.renew(Owner::vertex, 1);
  EXPECT_EQ(pairs(FeatureKind::vf), (std::set<std::pair<Index, Index>>{{3, 11}}));
}

}  // namespace
}  // namespace volccd
