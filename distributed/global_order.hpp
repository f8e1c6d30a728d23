// What ranks have found, in one order over all of them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <volccd/distributed/exchange.hpp>
#include <volccd/distributed/result.hpp>

namespace volccd::distributed {

/// Moves contacts between ranks, so that those of all ranks, one rank after another, are in canonical order. About the
/// same number on each rank. Collective.
std::vector<RankContact> sort_over_ranks(Exchange& exchange, std::vector<RankContact> contacts);

/// The same for pairs of ids, in ascending order.
std::vector<std::array<std::int64_t, 2>> sort_over_ranks(Exchange& exchange,
                                                         std::vector<std::array<std::int64_t, 2>> pairs);

}  // namespace volccd::distributed
