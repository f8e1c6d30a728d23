#include <volccd/experiments/records/record_file.hpp>

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/output_file.hpp>
#include <volccd/experiments/records/stats_json.hpp>

namespace volccd {

using nlohmann::json;

RecordFile::RecordFile(const std::string& folder, const std::string& name, const json& identity)
    : name_(name),
      file_((std::filesystem::path(folder) / (name + ".json")).string()),
      incomplete_((std::filesystem::path(folder) / (name + ".incomplete.jsonl")).string()) {
  read_back(identity);
  resumed_ = keys_.size();
  // Written anew, so that a line without an end is gone.
  std::string text = identity.dump() + "\n";
  std::string lines;
  {
    std::ifstream in(incomplete_);
    std::size_t kept = 0;
    std::string line;
    std::getline(in, line);
    while (kept < keys_.size() && std::getline(in, line)) lines += line + "\n", ++kept;
  }
  write_text_file(incomplete_, text + lines);
  out_.open(incomplete_, std::ios::app);
  if (!out_) throw InputError(incomplete_, "", "cannot be written");
}

void RecordFile::read_back(const json& identity) {
  std::ifstream in(incomplete_);
  std::string line;
  if (!in || !std::getline(in, line)) return;
  if (json::parse(line, nullptr, false) != identity) {
    replaced_ = true;
    return;
  }
  while (std::getline(in, line)) {
    const json entry = json::parse(line, nullptr, false);
    if (!entry.is_object() || !entry.contains("key") || !entry.contains("rows")) return;
    keys_.insert(entry.at("key").get<std::string>());
    for (const json& row : entry.at("rows")) rows_.push_back(row);
  }
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
