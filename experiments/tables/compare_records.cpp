#include <volccd/experiments/tables/compare_records.hpp>

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/experiments/tables/median.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// One motion of an entrant: seconds of all rounds, and counts.
struct Samples {
  std::vector<double> seconds;
  double tests = 0;
  std::string contacts;
};
using Entrants = std::map<std::string, std::map<int, Samples>>;

Entrants entrants_of(const json& record) {
  Entrants entrants;
  for (const json& row : record.at("rows")) {
    std::string key;
    for (const char* column : {"table", "scene", "motion_model", "edges", "pipeline", "variant"}) {
      const std::string value = row.at(column);
      if (!value.empty()) key += (key.empty() ? "" : " ") + value;
    }
    Samples& samples = entrants[key][row.at("motion").get<int>()];
    samples.seconds.push_back(row.at("seconds").get<double>() + row.at("topology_seconds").get<double>());
    samples.tests = row.at("vf_tests").get<double>() + row.at("ee_tests").get<double>();
    samples.contacts = row.at("contacts_hash").get<std::string>();
  }
  return entrants;
}

double spread(const Samples& samples) {
  const auto [low, high] = std::minmax_element(samples.seconds.begin(), samples.seconds.end());
  const double middle = median(samples.seconds);
  return middle > 0 ? (*high - *low) / middle : 0;
}

/// Operations have rows of another kind, which are not compared.
bool has_timed_rows(const json& record) {
  const auto rows = record.find("rows");
  return rows != record.end() && !rows->empty() && rows->front().contains("pipeline");
}

std::vector<std::string> records_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const json record = entry.path().extension() == ".json" ? read_json_file(entry.path().string()) : json();
    if (record.is_object() && record.value("schema", 0) == kRecordSchema && has_timed_rows(record)) names.push_back(entry.path().filename().string());
  }
  if (error) throw InputError(folder, "", "cannot be read: " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

void compare(const std::string& name, const Entrants& a, const Entrants& b, RecordComparison& result) {
  for (const auto& [key, motions] : a) {
    const auto other = b.find(key);
    if (other == b.end()) continue;
    double before = 0, after = 0, spread_a = 0, spread_b = 0;
    std::size_t common = 0;
    bool same = true;
    for (const auto& [motion, samples] : motions) {
      const auto there = other->second.find(motion);
      if (there == other->second.end()) continue;
      ++common;
      before += median(samples.seconds), after += median(there->second.seconds);
      spread_a += spread(samples), spread_b += spread(there->second);
      same &= samples.tests == there->second.tests && samples.contacts == there->second.contacts;
    }
    if (common == 0 || before <= 0) continue;
    const double ratio = after / before, tolerance = std::max(0.03, std::max(spread_a, spread_b) / static_cast<double>(common));
    const bool slower = ratio > 1 + tolerance, faster = ratio < 1 / (1 + tolerance);
    ++result.compared;
    result.slower += slower, result.faster += faster, result.other_counts += !same;
    if (slower || faster || !same)
      result.table.add({name, key, fmt::format("{:.3g}", 1e3 * before / static_cast<double>(common)),
                        fmt::format("{:.3g}", 1e3 * after / static_cast<double>(common)), fmt::format("{:.3f}", ratio),
                        fmt::format("{:.1f} %", 100 * tolerance), slower ? "slower" : faster ? "faster" : "-",
                        same ? "same" : "OTHER"});
  }
}

}  // namespace

RecordComparison compare_records(const std::string& folder_a, const std::string& folder_b) {
  RecordComparison result{TextTable({"record", "entrant", "ms, A", "ms, B", "B/A", "spread", "time", "counts"})};
  const std::vector<std::string> in_b = records_in(folder_b);
  for (const std::string& name : records_in(folder_a)) {
    if (std::find(in_b.begin(), in_b.end(), name) == in_b.end()) continue;
    const auto entrants = [&](const std::string& folder) {
      return entrants_of(read_record((std::filesystem::path(folder) / name).string()));
    };
    compare(std::filesystem::path(name).stem().string(), entrants(folder_a), entrants(folder_b), result);
  }
  if (result.compared == 0)
    throw InputError(folder_b, "", "has no row in common with " + folder_a + "; both are folders that `experiment run` filled");
  return result;
}

}  // namespace volccd
