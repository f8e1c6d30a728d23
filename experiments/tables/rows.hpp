// Rows of a record, grouped and summed up for tables.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

/// A selection of rows. It holds pointers into a record, which must outlive it.
class Rows {
 public:
  Rows() = default;
  /// All rows of a record. Throws InputError if it has none.
  explicit Rows(const nlohmann::json& record);

  bool empty() const { return rows_.empty(); }
  std::size_t size() const { return rows_.size(); }
  const nlohmann::json& front() const { return *rows_.front(); }
  const nlohmann::json& back() const { return *rows_.back(); }

  /// The rows in which the column has this value (text or number).
  Rows with(const std::string& column, const nlohmann::json& value) const;
  /// The rows in which the column has one of these values.
  Rows with_any(const std::string& column, const std::vector<nlohmann::json>& values) const;
  /// The distinct values of a column, in the order of the rows.
  std::vector<nlohmann::json> values(const std::string& column) const;
  /// The rows of each combination of values that occurs. The order is that of loops over values(), the first column
  /// outermost.
  std::vector<Rows> groups(const std::vector<std::string>& columns) const;
  /// The value of a column in the first row.
  const nlohmann::json& value(const std::string& column) const;

  /// For each step, the sum of the columns in each round.
  std::map<int, std::vector<double>> by_round(const std::vector<std::string>& columns) const;
  /// For each step, the median over rounds of by_round().
  std::vector<double> by_step(const std::vector<std::string>& columns) const;
  /// Mean (the paper's average) of by_step(), in milliseconds for columns in seconds.
  double mean_ms(const std::vector<std::string>& columns) const;
  /// Sum, or median, over steps of the median over rounds (counts are the same in every round).
  double sum(const std::string& column) const;
  double median(const std::string& column) const;
  /// VF and EE tests, summed over steps.
  double tests() const { return sum("vf_tests") + sum("ee_tests"); }
  std::size_t steps() const { return values("step").size(); }

 private:
  std::vector<const nlohmann::json*> rows_;
};

/// Columns of the time of a step, without and with the time to edit the topology.
extern const std::vector<std::string> kStepTime, kStepAndEditTime;

}  // namespace volccd
