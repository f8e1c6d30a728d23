#include <volccd/program/rank_table.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

namespace {

std::vector<std::string> row_of(const std::string& title, const distributed::RankStatistics& rank) {
  return {title,
          grouped(rank.elements),
          grouped(rank.copies),
          grouped(rank.halo),
          grouped(rank.tests),
          grouped(rank.contacts),
          fmt::format("{:.2f}", 1e3 * rank.seconds),
          fmt::format("{:.2f}", 1e3 * rank.piece_seconds),
          grouped(rank.bytes_received),
          grouped(rank.neighbours)};
}

}  // namespace

std::string rank_table(std::span<const distributed::RankStatistics> ranks, std::uint64_t elements, std::size_t width) {
  TextTable table({"rank", "elements", "copies", "halo", "tests", "contacts", "time [ms]", "pieces [ms]",
                   "bytes received", "neighbours"});
  distributed::RankStatistics all;
  double slowest = 0;
  for (std::size_t r = 0; r < ranks.size(); ++r) {
    table.add(row_of(std::to_string(r), ranks[r]));
    all += ranks[r];
    slowest = std::max(slowest, ranks[r].seconds);
  }
  table.rule();
  table.add(row_of("all", all));
  const double mean = all.seconds / static_cast<double>(ranks.size());
  return fmt::format("{}slowest rank / mean: {:.2f}; elements of all ranks / elements of the mesh: {:.2f}\n",
                     table.text(width), slowest / std::max(mean, 1e-300),
                     static_cast<double>(all.elements) / std::max(1.0, static_cast<double>(elements)));
}

nlohmann::json rank_json(std::span<const distributed::RankStatistics> ranks) {
  nlohmann::json rows = nlohmann::json::array();
  for (const distributed::RankStatistics& rank : ranks)
    rows.push_back({{"elements", rank.elements},
                    {"copies", rank.copies},
                    {"halo", rank.halo},
                    {"tests", rank.tests},
                    {"contacts", rank.contacts},
                    {"seconds", rank.seconds},
                    {"piece_seconds", rank.piece_seconds},
                    {"lists", rank.lists},
                    {"bytes_received", rank.bytes_received},
                    {"neighbours", rank.neighbours}});
  return rows;
}

}  // namespace volccd
