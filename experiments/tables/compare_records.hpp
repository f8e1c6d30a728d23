// Comparison of two folders of records: changes greater than the spread of the rounds.
#pragma once

#include <string>
#include <vector>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

struct RecordComparison {
  TextTable table;
  std::size_t compared = 0;  ///< entrants and scenes that both folders have
  std::size_t slower = 0;    ///< of those, slower by more than the spread and 3 %
  std::size_t faster = 0;
  std::size_t single = 0;        ///< with one round on a side: the spread is unknown; times are not compared
  std::size_t other_counts = 0;  ///< with different tests or contacts on the same step
};

/// Compares the records of the same name in both folders, entrant by entrant (table, scene, motion model, edges,
/// pipeline, variant), on the steps that both have; records whose rows are not runs of pipelines are left out. The
/// spread of an entrant is the mean over steps of (greatest - smallest) / median over rounds, the greater one of both
/// sides. Throws InputError for folders without a common record, and for an invalid record.
RecordComparison compare_records(const std::string& folder_a, const std::string& folder_b);

}  // namespace volccd
