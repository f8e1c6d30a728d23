// Two folders of records: what changed beyond the spread of the rounds.
#pragma once

#include <string>
#include <vector>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

struct RecordComparison {
  TextTable table;
  std::size_t compared = 0;  ///< entrants on scenes that both have
  std::size_t slower = 0;    ///< of those, slower beyond the spread and by more than 3 %
  std::size_t faster = 0;
  std::size_t single = 0;  ///< with one round on a side: their spread is unknown, and their times are not judged
  std::size_t other_counts = 0;  ///< with other tests or contacts on the same motion
};

/// Compares the records of the same name in both folders, entrant by entrant (table, scene, motion model, edges,
/// pipeline, variant), on the motions that both have; records whose rows are no runs of pipelines are left out. The
/// spread of an entrant is the mean over motions of (greatest - smallest) / median over rounds, the greater of both
/// sides. Throws InputError: no record in common, or a bad record.
RecordComparison compare_records(const std::string& folder_a, const std::string& folder_b);

}  // namespace volccd
