// Ranks in one process: what they exchange, whose turn it is, and how they end.
#include <volccd/distributed/in_process_exchange.hpp>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include <volccd/distributed/agreement.hpp>

#include "distributed/exchange_checks.hpp"
#include "distributed/rank_numbers.hpp"

namespace volccd::distributed {
namespace {

/// The text of the RankError that a run ends with.
std::string error_of(int ranks, FunctionRef<void(Exchange&)> body) {
  InProcessRanks in_process(ranks);
  try {
    in_process.run(body);
  } catch (const RankError& error) {
    // Later runs are as good as any.
    int sum = 0;
    in_process.run([&](Exchange& exchange) {
      std::uint64_t one = 1;
      exchange.allreduce({&one, 1}, Reduction::sum);
      sum += static_cast<int>(one);
    });
    EXPECT_EQ(sum, ranks * ranks);
    return error.what();
  }
  return "no error";
}

TEST(InProcessRanks, ReduceGatherAndSend) {
  for (const int ranks : test::kRankNumbers)
    InProcessRanks(ranks).run([](Exchange& exchange) { test::check_exchange(exchange); });
}

/// In later runs, too.
TEST(InProcessRanks, NeighbourhoodsStay) {
  InProcessRanks in_process(5);
  std::vector<std::unique_ptr<Neighbourhood>> graphs(5);
  in_process.run([&](Exchange& exchange) {
    graphs[static_cast<std::size_t>(exchange.rank())] = exchange.connect(test::destinations_of(exchange));
  });
  for (int run = 0; run < 2; ++run)
    in_process.run([&](Exchange& exchange) {
      test::check_neighbourhood(exchange, *graphs[static_cast<std::size_t>(exchange.rank())]);
    });
}

/// Between two operations no other rank computes, and ranks come in order.
TEST(InProcessRanks, OneComputesAtATimeInOrder) {
  std::vector<int> order;
  InProcessRanks(7).run([&](Exchange& exchange) {
    for (int round = 0; round < 3; ++round) {
      order.push_back(exchange.rank());
      exchange.allgather({});
    }
  });
  ASSERT_EQ(order.size(), 21u);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], static_cast<int>(i % 7));
}

TEST(InProcessRanks, AnExceptionEndsAllWithOneMessage) {
  for (const int failing : {0, 3, 6}) {
    int ended = 0;
    const std::string text = error_of(7, [&](Exchange& exchange) {
      exchange.connect({});
      if (exchange.rank() == failing) throw std::runtime_error("no more paper");
      exchange.allgather({});
      ++ended;
    });
    EXPECT_EQ(text, "rank " + std::to_string(failing) + " of 7: after connect: no more paper");
    EXPECT_EQ(ended, 0);
  }
  EXPECT_THROW(InProcessRanks(0), ConfigError);
}

TEST(InProcessRanks, RanksThatDoNotAgreeDoNotHang) {
  EXPECT_EQ(error_of(3,
                     [](Exchange& exchange) {
                       if (exchange.rank() == 1) return;
                       exchange.allgather({});
                     }),
            "rank 1 has ended, while rank 0 waits in allgather");
  EXPECT_EQ(error_of(3,
                     [](Exchange& exchange) {
                       if (exchange.rank() == 2)
                         exchange.connect({});
                       else
                         exchange.allgather({});
                     }),
            "rank 2 waits in connect, while rank 0 waits in allgather");
}

TEST(RunOnAll, AllThrowTheErrorOfTheLowestRank) {
  std::vector<std::string> texts;
  InProcessRanks(5).run([&](Exchange& exchange) {
    std::uint64_t value = static_cast<std::uint64_t>(exchange.rank());
    try {
      run_on_all(exchange, "weighing",
                 [&] {
                   if (exchange.rank() == 2) throw std::bad_alloc();
                   if (exchange.rank() == 4) throw InputError("scale", "weights", 7, "is broken");
                 },
                 {&value, 1});
    } catch (const RankError& error) {
      texts.push_back(error.what());
    }
    run_on_all(exchange, "weighing", [] {}, {&value, 1});
    EXPECT_EQ(value, 4u);
    require_same(exchange, "colour", "green");
    try {
      require_same(exchange, "colour", exchange.rank() == 3 ? "red" : "green");
    } catch (const RankError& error) {
      texts.push_back(error.what());
    }
  });
  ASSERT_EQ(texts.size(), 10u);
  EXPECT_EQ(std::ranges::count(texts, "rank 2 of 5: weighing: out of memory"), 5);
  EXPECT_EQ(std::ranges::count(texts, "the colour must be the same on all ranks: rank 0 has green; rank 3 has red"), 5);
}

}  // namespace
}  // namespace volccd::distributed
