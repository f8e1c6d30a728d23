#include <volccd/experiments/records/record_file.hpp>

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/stats_json.hpp>

namespace volccd {

using nlohmann::json;

RecordFile::RecordFile(const std::string& folder, const std::string& name, const json& identity)
    : name_(name),
      file_((std::filesystem::path(folder) / (name + ".json")).string()),
      incomplete_((std::filesystem::path(folder) / (name + ".incomplete.jsonl")).string()) {
  // The file is written again, which removes an incomplete last line.
  write_text_file(incomplete_, identity.dump() + "\n" + read_back(identity));
  resumed_ = keys_.size();
  out_.open(incomplete_, std::ios::app);
  if (!out_) throw InputError(incomplete_, "", "cannot be written");
}

std::string RecordFile::old_file() const {
  return std::filesystem::path(incomplete_).replace_extension(".old.jsonl").string();
}

std::string RecordFile::read_back(const json& identity) {
  std::ifstream in(incomplete_);
  std::string line, whole_lines;
  if (!in) return whole_lines;
  if (!std::getline(in, line) || json::parse(line, nullptr, false) != identity) {
    std::error_code error;
    std::filesystem::rename(incomplete_, old_file(), error);
    if (error) throw InputError(incomplete_, "", "is of another run and cannot be renamed: " + error.message());
    set_aside_ = true;
    return whole_lines;
  }
  while (std::getline(in, line)) {
    const json entry = json::parse(line, nullptr, false);
    const bool whole = entry.is_object() && entry.contains("key") && entry.at("key").is_string() &&
                       entry.contains("rows") && entry.at("rows").is_array();
    if (!whole) break;
    keys_.insert(entry.at("key").get<std::string>());
    for (const json& row : entry.at("rows")) rows_.push_back(row);
    whole_lines += line + "\n";
  }
  return whole_lines;
}

void RecordFile::add(const std::string& key, const std::vector<json>& rows) {
  out_ << json{{"key", key}, {"rows", rows}}.dump() << "\n" << std::flush;
  if (!out_) throw InputError(incomplete_, "", "cannot be written (is the disk full?)");
  keys_.insert(key);
  rows_.insert(rows_.end(), rows.begin(), rows.end());
}

void RecordFile::finish(const json& provenance, const json& summary) {
  std::string text = fmt::format("{{\"experiment\": {},\n\"schema\": {},\n\"complete\": true,\n\"provenance\": {},\n",
                                 json(name_).dump(), kRecordSchema, provenance.dump());
  text += "\"summary\": [";
  for (std::size_t i = 0; i < summary.size(); ++i) text += (i ? ",\n" : "\n") + summary[i].dump();
  text += "\n],\n\"rows\": [";
  for (std::size_t i = 0; i < rows_.size(); ++i) text += (i ? ",\n" : "\n") + rows_[i].dump();
  text += "\n]}\n";
  write_text_file(file_, text);
  out_.close();
  std::remove(incomplete_.c_str());
}

json read_record(const std::string& file) {
  json record = read_json_file(file);
  if (!record.is_object() || !record.contains("rows") || !record.contains("experiment"))
    throw InputError(file, "rows", "is missing: this is no record of an experiment");
  if (record.value("schema", 0) != kRecordSchema)
    throw InputError(file, "schema",
                     fmt::format("is {}, and this program reads {}; run the experiment again",
                                 record.value("schema", 0), kRecordSchema));
  return record;
}

}  // namespace volccd
