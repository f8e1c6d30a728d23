// Records of experiments on disk: each row is stored when it is measured, and the complete record replaces an old one
// at the end.
#pragma once

#include <cstddef>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

inline constexpr int kRecordSchema = 1;

/// The rows of a running experiment. They are appended to FOLDER/NAME.incomplete.jsonl: its first line is the identity
/// of the experiment, each further line is {"key": ..., "rows": [...]}. A later run of the same experiment reads the
/// rows of this file and continues; a last line that is not complete is dropped. finish() writes FOLDER/NAME.json,
/// which replaces the old record, and removes the other file. For one thread and one process at a time.
class RecordFile {
 public:
  /// `identity`: plan, build, machine. An existing file with a different identity is renamed to
  /// NAME.incomplete.old.jsonl, which replaces a file that was renamed before; set_aside() is then true. Throws
  /// InputError naming the file that cannot be read or written.
  RecordFile(const std::string& folder, const std::string& name, const nlohmann::json& identity);

  /// Whether the rows of this key have already been added.
  bool has(const std::string& key) const { return keys_.contains(key); }
  std::size_t resumed() const { return resumed_; }  ///< number of keys in the file of an earlier run
  bool set_aside() const { return set_aside_; }

  void add(const std::string& key, const std::vector<nlohmann::json>& rows);
  const std::vector<nlohmann::json>& rows() const { return rows_; }

  /// Writes {"experiment", "schema", "complete", "provenance", "summary", "rows"}, with one line for each row. Throws
  /// InputError.
  void finish(const nlohmann::json& provenance, const nlohmann::json& summary);

  const std::string& file() const { return file_; }
  const std::string& incomplete_file() const { return incomplete_; }
  std::string old_file() const;  ///< name of the file of a different experiment after it was renamed

 private:
  /// Reads the rows of an earlier run; returns their lines.
  std::string read_back(const nlohmann::json& identity);

  std::string name_, file_, incomplete_;
  std::set<std::string> keys_;
  std::vector<nlohmann::json> rows_;
  std::size_t resumed_ = 0;
  bool set_aside_ = false;
  std::ofstream out_;
};

/// Reads a record written by finish(). Throws InputError if there is no such file, it is not JSON, it has a different
/// schema, or it has no rows.
nlohmann::json read_record(const std::string& file);

}  // namespace volccd
