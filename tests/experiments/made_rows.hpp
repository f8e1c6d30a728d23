// The rows that an experiment makes by itself.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/catalog.hpp>

#include "support/scratch_folder.hpp"

namespace volccd::test {

/// `make`: ExperimentKind::rows.
inline std::vector<nlohmann::json> made_rows(void (*make)(const PlanContext&, RecordFile&),
                                             const PlanContext& context) {
  const ScratchFolder folder;
  RecordFile record(folder / ".", "made", nlohmann::json::object());
  make(context, record);
  return record.rows();
}

}  // namespace volccd::test
