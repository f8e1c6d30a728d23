// The results by rank of `volccd detect --ranks`.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <volccd/distributed/result.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// A row for each rank, with sums over the steps for which `ranks` are sums, then the share of the slowest and the sums
/// of all, in lines of `width`. `elements`: those of the whole mesh, summed over the same steps.
std::string rank_table(std::span<const distributed::RankStatistics> ranks, std::uint64_t elements,
                       std::size_t width = kTextWidth);

/// The same rows (docs/output.schema.json).
nlohmann::json rank_json(std::span<const distributed::RankStatistics> ranks);

}  // namespace volccd
