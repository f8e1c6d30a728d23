#include <volccd/distributed/global_order.hpp>

#include <algorithm>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/distributed/in_process_exchange.hpp>

#include "distributed/rank_numbers.hpp"

namespace volccd::distributed {
namespace {

using Pairs = std::vector<std::array<std::int64_t, 2>>;

/// The parts of all ranks after they were sorted, one after another. `most`: pairs of a rank.
Pairs sorted_pairs(int ranks, std::size_t max_pairs, std::vector<std::size_t>& counts) {
  std::vector<Pairs> parts(static_cast<std::size_t>(ranks));
  Pairs all;
  InProcessRanks(ranks).run([&](Exchange& exchange) {
    Random random(static_cast<std::uint64_t>(exchange.rank()) + 1);
    Pairs mine;
    for (std::size_t i = random.below(max_pairs + 1); i > 0; --i)
      mine.push_back(
          {static_cast<std::int64_t>(random.below(50)) - 25, static_cast<std::int64_t>(1000 * i) + exchange.rank()});
    all.insert(all.end(), mine.begin(), mine.end());
    parts[static_cast<std::size_t>(exchange.rank())] = sort_over_ranks(exchange, mine);
  });
  std::ranges::sort(all);
  Pairs result;
  for (const Pairs& part : parts) {
    counts.push_back(part.size());
    result.insert(result.end(), part.begin(), part.end());
  }
  EXPECT_EQ(result, all);
  return result;
}

TEST(GlobalOrder, PairsOfAllRanks) {
  for (const int ranks : test::kRankNumbers)
    for (const std::size_t max_pairs : {0, 1, 3, 1000}) {
      std::vector<std::size_t> counts;
      const std::size_t all = sorted_pairs(ranks, max_pairs, counts).size();
      if (max_pairs == 1000) {
        EXPECT_LT(*std::ranges::max_element(counts), 2 * all / counts.size() + 100);
      }
    }
}

/// Most ranks have nothing, and one has everything twice as often as its samples; keys at which parts begin are there.
TEST(GlobalOrder, OneRankHasAll) {
  for (const int ranks : {2, 5}) {
    std::vector<Pairs> parts(static_cast<std::size_t>(ranks));
    InProcessRanks(ranks).run([&](Exchange& exchange) {
      Pairs mine;
      for (std::int64_t i = 0; exchange.rank() == 1 && i < 500; ++i) mine.push_back({500 - i, 0});
      parts[static_cast<std::size_t>(exchange.rank())] = sort_over_ranks(exchange, mine);
    });
    std::int64_t next = 1;
    for (const Pairs& part : parts) {
      EXPECT_GE(part.size(), 500u / static_cast<unsigned>(ranks) - 20);
      for (const auto& pair : part) EXPECT_EQ(pair[0], next++);
    }
    EXPECT_EQ(next, 501);
  }
}

TEST(GlobalOrder, ContactsAreInCanonicalOrder) {
  std::vector<RankContact> all;
  std::vector<std::vector<RankContact>> parts(4);
  InProcessRanks(4).run([&](Exchange& exchange) {
    std::vector<RankContact> mine;
    for (std::int64_t i = 0; i < 40; ++i) {
      RankContact contact{.kind = i % 2 == 0 ? FeatureKind::ee : FeatureKind::vf, .toi = 0.01 * static_cast<double>(i)};
      contact.vertices = {i * 7 % 11, exchange.rank(), i, (std::int64_t{1} << 40) + i};
      contact.elements = {i, -i};
      contact.objects = {3, exchange.rank()};
      contact.normal = Vec3(1, 2, static_cast<double>(i));
      contact.weights = {0.5, 0.25, 0.125, static_cast<double>(i)};
      contact.at_start = i % 3 == 0;
      contact.gap = 0.5;
      mine.push_back(contact);
    }
    all.insert(all.end(), mine.begin(), mine.end());
    parts[static_cast<std::size_t>(exchange.rank())] = sort_over_ranks(exchange, mine);
  });
  std::ranges::sort(all, [](const RankContact& x, const RankContact& y) { return canonical_less(x, y); });
  std::vector<RankContact> sorted;
  for (const auto& part : parts) sorted.insert(sorted.end(), part.begin(), part.end());
  EXPECT_EQ(sorted, all);
}

}  // namespace
}  // namespace volccd::distributed
