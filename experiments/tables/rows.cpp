#include <volccd/experiments/tables/rows.hpp>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>

namespace volccd {

using nlohmann::json;

const std::vector<std::string> kStepTime = {"seconds"}, kStepAndEditTime = {"seconds", "topology_seconds"};

namespace {

double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

const json& at(const json& row, const std::string& column) {
  const auto place = row.find(column);
  if (place == row.end())
    throw InputError("record", "rows", fmt::format("a row has no column '{}': {}", column, row.dump()));
  return *place;
}

}  // namespace

Rows::Rows(const json& record) {
  if (!record.contains("rows")) throw InputError("record", "rows", "is missing");
  for (const json& row : record.at("rows")) rows_.push_back(&row);
  if (rows_.empty()) throw InputError("record", "rows", "has none");
}

Rows Rows::with(const std::string& column, const json& value) const { return with_any(column, {value}); }

Rows Rows::with_any(const std::string& column, const std::vector<json>& values) const {
  Rows result;
  for (const json* row : rows_)
    if (std::find(values.begin(), values.end(), at(*row, column)) != values.end()) result.rows_.push_back(row);
  return result;
}

std::vector<json> Rows::values(const std::string& column) const {
  std::vector<json> result;
  for (const json* row : rows_)
    if (const json& value = at(*row, column); std::find(result.begin(), result.end(), value) == result.end())
      result.push_back(value);
  return result;
}

std::vector<Rows> Rows::groups(const std::vector<std::string>& columns) const {
  std::vector<Rows> groups = {*this};
  for (const std::string& column : columns) {
    std::vector<Rows> finer;
    for (const Rows& group : groups) {
      const auto begin = static_cast<std::ptrdiff_t>(finer.size());
      for (const json* row : group.rows_) {
        const json& value = at(*row, column);
        auto place = std::find_if(finer.begin() + begin, finer.end(),
                                  [&](const Rows& listed) { return listed.value(column) == value; });
        if (place == finer.end()) place = finer.insert(place, Rows());
        place->rows_.push_back(row);
      }
    }
    groups = std::move(finer);
  }
  return groups;
}

const json& Rows::value(const std::string& column) const { return at(front(), column); }

std::map<int, std::vector<double>> Rows::by_round(const std::vector<std::string>& columns) const {
  std::map<int, std::vector<double>> rounds;
  for (const json* row : rows_) {
    double sum = 0;
    for (const std::string& column : columns) sum += at(*row, column).get<double>();
    rounds[at(*row, "step").get<int>()].push_back(sum);
  }
  return rounds;
}

std::vector<double> Rows::by_step(const std::vector<std::string>& columns) const {
  std::vector<double> result;
  for (auto& [step, values] : by_round(columns)) result.push_back(volccd::median(std::move(values)));
  return result;
}

double Rows::mean_ms(const std::vector<std::string>& columns) const { return 1e3 * mean(by_step(columns)); }
double Rows::median(const std::string& column) const { return volccd::median(by_step({column})); }

double Rows::sum(const std::string& column) const {
  const std::vector<double> values = by_step({column});
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace volccd
