#include <volccd/report/record_data.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/io/stats_json.hpp>

namespace volccd {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string file_in(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / (name + ".json")).string();
}

json table_json(const TitledTable& table) {
  const auto& rows = table.table.rows();
  json body = json::array();
  for (std::size_t r = 1; r < rows.size(); ++r) body.push_back(rows[r]);
  return {{"title", table.title}, {"note", table.note}, {"header", rows.at(0)}, {"rows", std::move(body)}};
}

/// Numbers of the steps, one curve each; objects give a curve for each of their numbers.
json curves_of(const json& steps) {
  std::map<std::string, std::vector<json>> curves;
  for (const json& step : steps)
    for (const auto& [key, value] : step.items()) {
      if (value.is_number()) curves[key].push_back(value);
      if (value.is_object())
        for (const auto& [inner, number] : value.items())
          if (number.is_number()) curves[key + ", " + inner].push_back(number);
    }
  json result = json::object();
  for (auto& [name, values] : curves)
    if (values.size() == steps.size()) result[name] = std::move(values);
  return result;
}

/// The curves of records that have one row for each scene and step.
json curves_of_rows(const json& rows) {
  json by_scene = json::object(), curves = json::array();
  for (const json& row : rows) by_scene[row.at("scene").get<std::string>()].push_back(row);
  for (const auto& [scene, steps] : by_scene.items())
    curves.push_back({{"scene", scene}, {"values", curves_of(steps)}});
  return curves;
}

json harness_record(const ExperimentKind& kind, const std::string& folder, const json& record) {
  json tables = json::array();
  for (const TitledTable& table : kind.tables(record)) tables.push_back(table_json(table));
  json provenance = record.value("provenance", json::object());
  provenance.erase("plan");
  const std::string setting = provenance.value("setting", "quick"), options = provenance.value("options", "");
  return {{"name", kind.name},
          {"description", kind.description},
          {"file", file_in(folder, kind.name)},
          {"command", fmt::format("volccd experiment run {} --{} --threads {} {}-o {}", kind.name, setting,
                                  provenance.value("threads", 1), options.empty() ? "" : options + " ", folder)},
          {"row_count", record.at("rows").size()},
          {"provenance", std::move(provenance)},
          {"tables", std::move(tables)},
          {"summary", record.value("summary", json::array())},
          {"curves", kind.curves ? curves_of_rows(record.at("rows")) : json::array()}};
}

/// Records that are a list with an entry for each scene.
struct SceneRecordKind {
  const char *name, *command, *description;
  TitledTable (*table)(const std::vector<json>& records);
};
constexpr SceneRecordKind kSceneRecords[] = {
    {"scenes", "scenes", "the simulated scenes: sizes, motion, contacts, edits, energy", scene_table}};

json scene_list_record(const SceneRecordKind& kind, const std::string& folder) {
  const std::string file = file_in(folder, kind.name);
  const json record = read_json_file(file);
  if (!record.is_array() || record.empty() || !record[0].is_object() || !record[0].contains("steps"))
    throw InputError(
        file, "",
        "is not a list of scenes: make it again by `volccd experiment run " + std::string(kind.command) + "`");
  json provenance = record[0].value("machine", json::object());
  json scenes = json::object(), curves = json::array();
  for (const json& scene : record) {
    const std::string name = scene.at("scene").get<std::string>();
    scenes[name] = scene.value("machine", json::object());
    curves.push_back({{"scene", name}, {"values", curves_of(scene.at("steps"))}});
  }
  provenance["scenes"] = std::move(scenes);
  TitledTable table = kind.table(std::vector<json>(record.begin(), record.end()));
  table.title = kind.description;
  return {{"name", kind.name},
          {"description", kind.description},
          {"file", file},
          {"command", fmt::format("volccd experiment run {} -o {}", kind.command, folder)},
          {"row_count", record.size()},
          {"provenance", std::move(provenance)},
          {"tables", json::array({table_json(table)})},
          {"summary", json::array()},
          {"curves", std::move(curves)}};
}

constexpr const char* kTextColumns[] = {"table",        "scene", "pipeline", "variant",
                                        "motion_model", "edges", "shells",   "mesh"};
constexpr const char* kRoles[] = {"broad_phase", "element_culling", "assignment",  "orphans",
                                  "flood",       "feature_filter",  "narrow_phase"};
constexpr const char* kCounts[] = {"elements",    "element_pairs",     "adjacent_pairs", "surviving_pairs",
                                   "owned_tests", "orphan_tests",      "vf_tests",       "ee_tests",
                                   "contacts",    "contacts_at_start", "touching_pairs", "topology_seconds"};

double number(const json& row, const std::string& column) {
  const auto at = row.find(column);
  return at != row.end() && at->is_number() ? at->get<double>() : 0;
}

/// Six significant digits, so that the page stays small.
json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return json::parse(fmt::format("{:.6g}", value));
}

class Points {
 public:
  void add(const std::string& record, const json& rows) {
    std::map<std::vector<std::string>, std::vector<const json*>> groups;
    std::vector<std::vector<std::string>> order;
    for (const json& row : rows) {
      if (!row.contains("pipeline") || !row.contains("step") || !row.contains("seconds")) continue;
      std::vector<std::string> key{record};
      for (const char* column : kTextColumns) key.push_back(row.value(column, std::string()));
      for (const char* column : {"threads", "elements", "step", "motion_scale"})
        key.push_back(fmt::format("{}", number(row, column)));
      const auto [at, fresh] = groups.try_emplace(key);
      if (fresh) order.push_back(key);
      at->second.push_back(&row);
    }
    for (const auto& key : order) add_group(key, groups.at(key));
  }

  json build() { return {{"texts", std::move(texts_)}, {"columns", std::move(columns_)}}; }

 private:
  void add_group(const std::vector<std::string>& key, const std::vector<const json*>& rows) {
    columns_["record"].push_back(text(key[0]));
    for (std::size_t i = 0; i < std::size(kTextColumns); ++i) columns_[kTextColumns[i]].push_back(text(key[i + 1]));
    const json& first = *rows.front();
    for (const char* column : {"threads", "step", "motion_scale"}) columns_[column].push_back(first.value(column, 1.0));
    columns_["rounds"].push_back(rows.size());
    const auto all = [&](auto&& value) {
      std::vector<double> values;
      for (const json* row : rows) values.push_back(value(*row));
      return values;
    };
    const std::vector<double> seconds = all([](const json& row) { return number(row, "seconds"); });
    columns_["seconds"].push_back(rounded(median(seconds)));
    columns_["seconds_min"].push_back(rounded(*std::min_element(seconds.begin(), seconds.end())));
    columns_["seconds_max"].push_back(rounded(*std::max_element(seconds.begin(), seconds.end())));
    for (const std::string role : kRoles)
      columns_[role + "_s"].push_back(rounded(median(
          all([&](const json& row) { return number(row, role + "_prepare_s") + number(row, role + "_run_s"); }))));
    for (const char* column : kCounts)
      columns_[column].push_back(rounded(median(all([&](const json& row) { return number(row, column); }))));
  }

  std::size_t text(const std::string& value) {
    const auto found = std::find(texts_.begin(), texts_.end(), value);
    if (found != texts_.end()) return static_cast<std::size_t>(found - texts_.begin());
    texts_.push_back(value);
    return texts_.size() - 1;
  }

  json texts_ = json::array(), columns_ = json::object();
};

}  // namespace

RecordData data_of_records(const std::string& folder) {
  json records = json::array();
  Points points;
  for (const ExperimentKind& kind : experiment_kinds()) {
    const std::string file = file_in(folder, kind.name);
    if (!fs::exists(file)) continue;
    const json record = read_record(file);
    records.push_back(harness_record(kind, folder, record));
    points.add(kind.name, record.at("rows"));
  }
  for (const SceneRecordKind& kind : kSceneRecords)
    if (fs::exists(file_in(folder, kind.name))) records.push_back(scene_list_record(kind, folder));
  if (records.empty())
    throw InputError(folder, "",
                     "has no record of an experiment (NAME.json); `volccd experiment run NAME -o FOLDER` writes one, "
                     "`volccd experiment list` has the names");
  return {std::move(records), points.build()};
}

std::vector<RecordedInput> inputs_of(const json& records) {
  std::vector<RecordedInput> inputs;
  for (const json& record : records)
    for (const json& input : record.at("provenance").value("inputs", json::array())) {
      const std::string file = input.value("file", std::string());
      auto at = std::find_if(inputs.begin(), inputs.end(), [&](const RecordedInput& i) { return i.file == file; });
      if (at == inputs.end())
        at = inputs.insert(at, {input.value("scene", std::string()), file, input.value("fnv1a", std::string()), {}});
      at->records.push_back(record.at("name").get<std::string>());
    }
  return inputs;
}

}  // namespace volccd
