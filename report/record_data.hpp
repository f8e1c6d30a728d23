// The records of a folder as data for the report's page: tables as they are printed, medians of the rows, provenance.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

/// Of all records in a folder that belong to an experiment.
struct RecordData {
  /// In the order of `volccd experiment list`: {"name", "description", "file", "command", "provenance", "tables":
  /// [{"title", "note", "header", "rows"}], "summary", "curves"}. The provenance is that of the record, without the
  /// plan. "command" repeats the measurement. A record of simulated scenes has a provenance for each scene, and
  /// "curves": values of its steps over time.
  nlohmann::json records;
  /// Rows in long form, {"columns": {name: [values]}}: one for each record, table, scene, pipeline, variant, treatment
  /// of elements and step, with the number of rounds, the median time over rounds, the least and the greatest one, and
  /// medians of stage times and counts. Texts are indices into "texts". Only rows with a pipeline and a motion are
  /// used, which are those of the harness.
  nlohmann::json points;
};

/// Throws InputError for a folder without such records, and for a record that cannot be read.
RecordData data_of_records(const std::string& folder);

/// A file that records name as the sequence of a scene.
struct RecordedInput {
  std::string scene, file, fnv1a;  ///< the name in rows, without folder; the hash of the file that was measured
  std::vector<std::string> records;
};

/// Each file once; a scene may have several files with different names.
std::vector<RecordedInput> inputs_of(const nlohmann::json& records);

}  // namespace volccd
