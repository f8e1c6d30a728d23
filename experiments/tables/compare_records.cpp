#include <volccd/experiments/tables/compare_records.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <span>

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
  std::set<int> rounds;
  double tests = 0;
  std::string contacts;
};
struct EntrantSamples {
  std::string question;  ///< what it has in common with those that were measured in turn with it
  std::map<int, Samples> steps;
};
using Entrants = std::map<std::string, EntrantSamples>;

/// Columns that distinguish entrants, and the values that most rows have. Those of the question come first.
constexpr std::pair<const char*, const char*> kColumns[] = {
    {"table", ""},         {"scene", ""},     {"motion_model", "linear"}, {"edges", "triangulated"},
    {"shells", "surface"}, {"mesh", "whole"}, {"pipeline", ""},           {"variant", ""}};
constexpr std::size_t kColumnsOfQuestion = 5;

/// The values of the first columns that are not the usual ones, and what all names have.
std::string name_of(const json& row, std::size_t columns) {
  std::string name;
  const auto append = [&](const std::string& word) { name += (name.empty() ? "" : " ") + word; };
  for (const auto& [column, usual] : std::span(kColumns).first(columns))
    if (const std::string value = row.at(column); value != usual) append(value);
  append(fmt::format("threads={}", row.at("threads").get<unsigned>()));
  if (const double separation = row.at("separation"); separation != 0) append(fmt::format("separation={}", separation));
  return name;
}

Entrants entrants_of(const std::string& file) {
  Entrants entrants;
  const json record = read_record(file);
  std::int64_t index = 0;
  try {
    for (const json& row : record.at("rows")) {
      const std::string key = name_of(row, std::size(kColumns));
      const int step = row.at("step"), round = row.at("round");
      EntrantSamples& entrant = entrants[key];
      entrant.question = name_of(row, kColumnsOfQuestion);
      Samples& samples = entrant.steps[step];
      if (!samples.rounds.insert(round).second)
        throw InputError(file, "rows", index,
                         fmt::format("is a second row of {}, step {}, round {}", key, step, round));
      const double seconds = row.at("seconds").get<double>() + row.at("topology_seconds").get<double>();
      if (!(seconds > 0)) throw InputError(file, "rows", index, fmt::format("a step took {} s", seconds));
      samples.seconds.push_back(seconds);
      samples.tests = row.at("vf_tests").get<double>() + row.at("ee_tests").get<double>();
      samples.contacts = row.at("contacts_hash").get<std::string>();
      ++index;
    }
  } catch (const json::exception& error) {
    throw InputError(file, "rows", index, fmt::format("is not a run of a pipeline: {}", error.what()));
  }
  return entrants;
}

double spread(const Samples& samples) {
  const auto [low, high] = std::minmax_element(samples.seconds.begin(), samples.seconds.end());
  const double middle = median(samples.seconds);
  return (*high - *low) / middle;
}

/// Whether the rows are runs of pipelines. Those of `operations`, `feature-sets` and others are not, and are not
/// compared.
bool has_timed_rows(const json& record) {
  const auto rows = record.find("rows");
  return rows != record.end() && !rows->empty() && rows->front().contains("contacts_hash");
}

/// The names of all records in the folder, and whether they have times.
std::map<std::string, bool> records_in(const std::string& folder) {
  std::map<std::string, bool> records;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() != ".json") continue;
    const json record = read_json_file(entry.path().string());
    records[entry.path().stem().string()] =
        record.is_object() && record.value("schema", 0) == kRecordSchema && has_timed_rows(record);
  }
  if (error) throw InputError(folder, "", "cannot be read: " + error.message());
  return records;
}

/// An entrant on the steps that both sides have.
struct Change {
  std::size_t steps = 0;
  double before = 0, after = 0;       ///< seconds, sums over steps
  double spread_a = 0, spread_b = 0;  ///< sums over steps
  bool same_counts = true;
  bool single = false;  ///< a side has one round: the spread is unknown
  double drift = 1;     ///< of the question

  double ratio() const { return after / before; }
  double tolerance() const {
    const double spread = std::max(spread_a, spread_b) / static_cast<double>(steps);
    return single ? kMaxTimeTolerance : std::clamp(spread, kMinTimeTolerance, kMaxTimeTolerance);
  }
  bool slower() const { return ratio() > drift * (1 + tolerance()); }
  bool faster() const { return ratio() < drift / (1 + tolerance()); }
};

Change change_of(const std::map<int, Samples>& a, const std::map<int, Samples>& b) {
  Change change;
  for (const auto& [step, before] : a) {
    const auto there = b.find(step);
    if (there == b.end()) continue;
    const Samples& after = there->second;
    ++change.steps;
    change.before += median(before.seconds);
    change.after += median(after.seconds);
    change.spread_a += spread(before);
    change.spread_b += spread(after);
    change.same_counts &= before.tests == after.tests && before.contacts == after.contacts;
    change.single |= before.seconds.size() == 1 || after.seconds.size() == 1;
  }
  return change;
}

/// Notes the keys that one side has alone.
template <class Map>
void note_missing(const Map& a, const Map& b, const std::string& what, RecordComparison& result) {
  const auto note = [&](const Map& here, const Map& there, const char* side) {
    std::vector<std::string> missing;
    for (const auto& [key, value] : here)
      if (!there.contains(key)) missing.push_back(fmt::format("{}", key));
    if (!missing.empty())
      result.only_on_one_side.push_back(fmt::format("{}{}: only in {}", what, fmt::join(missing, ", "), side));
  };
  note(a, b, "A");
  note(b, a, "B");
}

/// Sets the drift of the changes, and appends those of all questions.
void find_drifts(const std::string& name, const Entrants& entrants, std::map<std::string, Change>& changes,
                 std::vector<RecordComparison::Drift>& drifts) {
  std::map<std::string, std::vector<double>> questions;
  for (const auto& [key, change] : changes) questions[entrants.at(key).question].push_back(change.ratio());
  for (auto& [key, change] : changes)
    if (const auto& ratios = questions.at(entrants.at(key).question); ratios.size() >= kMinForDrift)
      change.drift = median(ratios);
  for (const auto& [question, ratios] : questions)
    if (ratios.size() >= kMinForDrift) drifts.push_back({fmt::format("{}, {}", name, question), median(ratios)});
}

void compare(const std::string& name, const Entrants& a, const Entrants& b, RecordComparison& result) {
  std::map<std::string, Change> changes;
  for (const auto& [key, entrant] : a) {
    const auto other = b.find(key);
    if (other == b.end()) continue;
    note_missing(entrant.steps, other->second.steps, fmt::format("{}, {}, steps ", name, key), result);
    const Change change = change_of(entrant.steps, other->second.steps);
    if (change.steps > 0) changes[key] = change;
  }
  find_drifts(name, a, changes, result.drifts);
  for (const auto& [key, change] : changes) {
    const bool slower = change.slower(), faster = change.faster();
    ++result.compared;
    result.slower += slower;
    result.faster += faster;
    result.other_counts += !change.same_counts;
    result.single += change.single;
    if (!slower && !faster && change.same_counts) continue;
    const auto ms = [steps = double(change.steps)](double seconds) { return number_text(1e3 * seconds / steps); };
    result.table.add({name, key, ms(change.before), ms(change.after), fmt::format("{:.3f}", change.ratio()),
                      fmt::format("{:.3f}", change.drift), fmt::format("{:.1f} %", 100 * change.tolerance()),
                      slower   ? "slower"
                      : faster ? "faster"
                               : "-",
                      change.same_counts ? "same" : "OTHER"});
  }
}

void compare_drifts(RecordComparison& result) {
  std::vector<RecordComparison::Drift>& drifts = result.drifts;
  std::sort(drifts.begin(), drifts.end(), [](const auto& a, const auto& b) { return a.ratio < b.ratio; });
  if (drifts.size() < kMinForDrift) return;
  std::vector<double> ratios;
  for (const RecordComparison::Drift& drift : drifts) ratios.push_back(drift.ratio);
  const double middle = median(ratios);
  for (const auto& [question, ratio] : drifts) {
    const bool slower = ratio > middle * (1 + kMaxTimeTolerance), faster = ratio < middle / (1 + kMaxTimeTolerance);
    result.slower += slower;
    result.faster += faster;
    if (slower || faster)
      result.table.add({question, "all pipelines", "-", "-", fmt::format("{:.3f}", ratio),
                        fmt::format("{:.3f}", middle), fmt::format("{:.1f} %", 100 * kMaxTimeTolerance),
                        slower ? "slower" : "faster", "-"});
  }
}

}  // namespace

RecordComparison compare_records(const std::string& folder_a, const std::string& folder_b) {
  RecordComparison result{
      TextTable({"record", "entrant", "ms, A", "ms, B", "B/A", "of all", "tolerance", "time", "counts"})};
  const std::map<std::string, bool> in_a = records_in(folder_a), in_b = records_in(folder_b);
  note_missing(in_a, in_b, "record ", result);
  for (const auto& [name, timed] : in_a) {
    const auto other = in_b.find(name);
    if (other == in_b.end()) continue;
    if (!timed && !other->second) result.without_times.push_back(name);
    if (timed != other->second)
      result.only_on_one_side.push_back(fmt::format("rows of {}: only in {}", name, timed ? "A" : "B"));
    if (!timed || !other->second) continue;
    const auto entrants = [file = name + ".json"](const std::string& folder) {
      return entrants_of((std::filesystem::path(folder) / file).string());
    };
    const Entrants a = entrants(folder_a), b = entrants(folder_b);
    note_missing(a, b, name + ", entrants ", result);
    compare(name, a, b, result);
  }
  compare_drifts(result);
  if (result.compared == 0)
    throw InputError(folder_b, "",
                     "has no row in common with " + folder_a + "; both are folders that `experiment run` filled");
  return result;
}

}  // namespace volccd
