// What every Exchange must do; called on each rank.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/distributed/exchange.hpp>

namespace volccd::test {

/// Rank r sends to all ranks that r + 1 divides: to itself only as rank 0.
inline bool sends(int from, int to) { return to % (from + 1) == 0; }

inline std::vector<int> destinations_of(distributed::Exchange& exchange) {
  std::vector<int> destinations;
  for (int r = 0; r < exchange.size(); ++r)
    if (sends(exchange.rank(), r)) destinations.push_back(r);
  return destinations;
}

/// Empty for some, and different in each round.
inline std::string message(int from, int to, int round) {
  return (from + to + round) % 4 == 0 ? ""
                                      : std::string(static_cast<std::size_t>(1000 * (to % 4)), 'x') +
                                            std::to_string(100 * from + to) + "," + std::to_string(round);
}

inline void check_neighbourhood(distributed::Exchange& exchange, distributed::Neighbourhood& graph) {
  std::vector<int> sources;
  for (int r = 0; r < exchange.size(); ++r)
    if (sends(r, exchange.rank())) sources.push_back(r);
  const auto to = graph.destinations();
  ASSERT_EQ(std::vector(graph.sources().begin(), graph.sources().end()), sources);
  ASSERT_EQ(std::vector(to.begin(), to.end()), destinations_of(exchange));
  for (int round = 0; round < 5; ++round) {
    std::vector<distributed::Bytes> messages;
    for (const int r : to) messages.push_back(distributed::to_bytes(message(exchange.rank(), r, round)));
    const auto received = graph.exchange(std::move(messages));
    ASSERT_EQ(received.size(), sources.size());
    for (std::size_t i = 0; i < sources.size(); ++i)
      EXPECT_EQ(distributed::text_of(received[i]), message(sources[i], exchange.rank(), round));
  }
}

inline void check_values(distributed::Exchange& exchange) {
  using distributed::Reduction;
  const auto mine = static_cast<std::uint64_t>(exchange.rank()), n = static_cast<std::uint64_t>(exchange.size());
  std::uint64_t values[] = {mine, mine + 5};
  exchange.allreduce(values, Reduction::sum);
  EXPECT_EQ(values[0], n * (n - 1) / 2);
  EXPECT_EQ(values[1], n * (n - 1) / 2 + 5 * n);
  std::uint64_t smallest = mine + 3, greatest = ~std::uint64_t{0} - mine;
  exchange.allreduce({&smallest, 1}, Reduction::min);
  exchange.allreduce({&greatest, 1}, Reduction::max);
  EXPECT_EQ(smallest, 3u);
  EXPECT_EQ(greatest, ~std::uint64_t{0}) << "values are not signed";
  const auto text = [](std::uint64_t r) { return r % 3 == 1 ? "" : std::string(r % 7, 'a') + std::to_string(r); };
  const auto texts = exchange.allgather(distributed::to_bytes(text(mine)));
  ASSERT_EQ(texts.size(), n);
  for (std::size_t r = 0; r < n; ++r) EXPECT_EQ(distributed::text_of(texts[r]), text(r));
}

inline void check_exchange(distributed::Exchange& exchange) {
  for (int round = 0; round < 3; ++round) {
    check_values(exchange);
    const auto graph = exchange.connect(destinations_of(exchange));
    const auto nobody = exchange.connect({});
    EXPECT_TRUE(nobody->sources().empty());
    EXPECT_TRUE(nobody->exchange({}).empty());
    check_neighbourhood(exchange, *graph);
    check_neighbourhood(exchange, *graph);
  }
}

}  // namespace volccd::test
