#include <volccd/experiments/tables/compare_records.hpp>

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/io/stats_json.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// One step of an entrant: seconds of all rounds, and counts.
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

/// Whether the rows are runs of pipelines. Those of `operations`, `feature-sets` and others are not, and are not
/// compared.
bool has_timed_rows(const json& record) {
  const auto rows = record.find("rows");
  return rows != record.end() && !rows->empty() && rows->front().contains("contacts_hash");
}

std::vector<std::string> records_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const json record = entry.path().extension() == ".json" ? read_json_file(entry.path().string()) : json();
    if (record.is_object() && record.value("schema", 0) == kRecordSchema && has_timed_rows(record))
      names.push_back(entry.path().filename().string());
  }
  if (error) throw InputError(folder, "", "cannot be read: " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

/// An entrant on the steps that both sides have.
struct Change {
  std::size_t steps = 0;
  double before = 0, after = 0;       ///< seconds, sums over steps
  double spread_a = 0, spread_b = 0;  ///< sums over steps
  bool same_counts = true;
  bool judged = true;  ///< both sides have several rounds: the spread is known

  double ratio() const { return after / before; }
  double tolerance() const { return std::max(0.03, std::max(spread_a, spread_b) / static_cast<double>(steps)); }
  bool slower() const { return judged && ratio() > 1 + tolerance(); }
  bool faster() const { return judged && ratio() < 1 / (1 + tolerance()); }
};

Change change_of(const std::map<int, Samples>& a, const std::map<int, Samples>& b) {
  Change change;
  for (const auto& [step, before] : a) {
    const auto there = b.find(step);
    if (there == b.end()) continue;
    const Samples& after = there->second;
    ++change.steps;
    change.before += median(before.seconds), change.after += median(after.seconds);
    change.spread_a += spread(before), change.spread_b += spread(after);
    change.same_counts &= before.tests == after.tests && before.contacts == after.contacts;
    change.judged &= before.seconds.size() > 1 && after.seconds.size() > 1;
  }
  return change;
}

void compare(const std::string& name, const Entrants& a, const Entrants& b, RecordComparison& result) {
  for (const auto& [key, steps] : a) {
    const auto other = b.find(key);
    if (other == b.end()) continue;
    const Change change = change_of(steps, other->second);
    if (change.steps == 0 || change.before <= 0) continue;
    const bool slower = change.slower(), faster = change.faster();
    ++result.compared;
    result.slower += slower, result.faster += faster, result.other_counts += !change.same_counts;
    result.single += !change.judged;
    if (!slower && !faster && change.same_counts) continue;
    const auto ms = [&](double seconds) { return fmt::format("{:.3g}", 1e3 * seconds / double(change.steps)); };
    result.table.add({name, key, ms(change.before), ms(change.after), fmt::format("{:.3f}", change.ratio()),
                      change.judged ? fmt::format("{:.1f} %", 100 * change.tolerance()) : "-",
                      slower   ? "slower"
                      : faster ? "faster"
                               : "-",
                      change.same_counts ? "same" : "OTHER"});
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
    throw InputError(folder_b, "",
                     "has no row in common with " + folder_a + "; both are folders that `experiment run` filled");
  return result;
}

}  // namespace volccd
