// Records of experiments on disk: rows are kept as they come, and a whole record replaces an old one at the end.
#pragma once

#include <cstddef>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

inline constexpr int kRecordSchema = 1;

/// Rows of an experiment that runs. They go to FOLDER/NAME.incomplete.jsonl as they come: its first line says what they
/// are rows of, each further line is {"key": ..., "rows": [...]}. A later run of the same experiment takes up what is
/// there; finish() writes FOLDER/NAME.json in the place of the old record, and removes the other file. A line that the
/// last run did not finish is dropped. One thread, and one process, at a time.
class RecordFile {
 public:
  /// `identity`: plan, build, machine. A file that is there with another identity is renamed to
  /// NAME.incomplete.old.jsonl, in the place of one that was renamed before, and set_aside() says so. Throws InputError
  /// naming the file that cannot be read or written.
  RecordFile(const std::string& folder, const std::string& name, const nlohmann::json& identity);

  /// Whether the rows of this key are there already.
  bool has(const std::string& key) const { return keys_.contains(key); }
  std::size_t resumed() const { return resumed_; }  ///< keys that were there at first
  bool set_aside() const { return set_aside_; }

  void add(const std::string& key, const std::vector<nlohmann::json>& rows);
  const std::vector<nlohmann::json>& rows() const { return rows_; }

  /// Writes {"experiment", "schema", "complete", "provenance", "summary", "rows"}, a row a line. Throws InputError.
  void finish(const nlohmann::json& provenance, const nlohmann::json& summary);

  const std::string& file() const { return file_; }
  const std::string& incomplete_file() const { return incomplete_; }
  std::string old_file() const;  ///< where another's rows were set aside

 private:
  /// Takes up the rows that are there; returns their lines.
  std::string read_back(const nlohmann::json& identity);

  std::string name_, file_, incomplete_;
  std::set<std::string> keys_;
  std::vector<nlohmann::json> rows_;
  std::size_t resumed_ = 0;
  bool set_aside_ = false;
  std::ofstream out_;
};

/// A record that finish() wrote. Throws InputError: no such file, no JSON, another schema, no rows.
nlohmann::json read_record(const std::string& file);

}  // namespace volccd
