#include <volccd/experiments/tables/operation_table.hpp>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/tables/operations.hpp>
#include <volccd/experiments/tables/query_source.hpp>

namespace volccd {

using nlohmann::json;

std::vector<json> operation_rows(const PlanContext& context) {
  const std::string scene = context.full ? "octopi" : "octopi-quick";
  const std::optional<std::string> file = context.file_of(scene);
  if (!file) throw ConfigError("operations: the scene " + scene + " is not there");
  QuerySourceConfig source;
  source.candidates = true;
  source.sample = 2048;
  source.motion = motion_count(*file) / 2;
  std::vector<json> rows;
  const json counts = operation_counts(load_queries(*file, source));
  if (counts.at("rows").empty()) throw ConfigError("operations: " + *file + " has no tests at its middle motion");
  for (json row : counts.at("rows")) {
    row["scene"] = "octopi";
    row["motion"] = source.motion;
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<TitledTable> operation_tables(const json& record) {
  TextTable table({"operation", "kind", "tests", "+ -", "*", "/", "paper: + -", "*", "/", "compare", "sqrt", "ns"});
  for (const json& row : record.at("rows")) {
    const auto mean = [&](const char* name) { return fmt::format("{:.1f}", row.at(name).get<double>()); };
    const auto printed = [&](const char* name) {
      const json& paper = row.at("paper");
      return paper.is_object() && paper.contains(name) && paper.at(name).is_number() ? paper.at(name).dump()
                                                                                     : std::string("-");
    };
    table.add({row.at("operation"), row.at("kind"), grouped(row.at("tests").get<std::uint64_t>()), mean("additions"),
               mean("multiplications"), mean("divisions"), printed("additions"), printed("multiplications"),
               printed("divisions"), mean("comparisons"), mean("square_roots"),
               fmt::format("{:.1f}", row.at("ns").get<double>())});
  }
  return {{"Section 7.1: floating-point operations of a test, means", table,
           "of the reference implementation of 2011, on tests whose features have overlapping boxes; one thread\n"}};
}

}  // namespace volccd
