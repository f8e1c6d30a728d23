// Comparison of two folders of records: changes greater than the spread of the rounds.
#pragma once

#include <string>
#include <vector>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// The comparison of two folders, A and B. The rows of an entrant have the same table, scene, motion model, edges,
/// shells, mesh, pipeline, variant, threads and separation; all other columns are measured, or number steps and rounds.
struct RecordComparison {
  /// How the time of all entrants of a question changed together.
  struct Drift {
    std::string question;
    double ratio;  ///< B/A
  };

  TextTable table;           ///< entrants and questions that differ
  std::size_t compared = 0;  ///< entrants that both folders have
  std::size_t slower = 0;    ///< entrants and questions, slower by more than the tolerance
  std::size_t faster = 0;
  std::vector<Drift> drifts = {};                  ///< by ratio
  std::size_t single = 0;                          ///< with one round on a side
  std::size_t other_counts = 0;                    ///< with different tests or contacts on the same step
  std::vector<std::string> only_on_one_side = {};  ///< records, entrants and steps, with the side that has them
  std::vector<std::string> without_times = {};     ///< records in both folders whose rows are not runs of pipelines
};

/// Least and greatest tolerance of times.
inline constexpr double kMinTimeTolerance = 0.03, kMaxTimeTolerance = 0.25;
/// With fewer entrants, a question has no drift; drifts are not compared if there are fewer.
inline constexpr std::size_t kMinForDrift = 3;

/// Compares the records of the same name in both folders, entrant by entrant, by the sum over the steps that both have
/// of the median over rounds. The tolerance of an entrant is the spread of its rounds, but within the two bounds, and
/// the greatest with a single round: greater changes are always seen. The spread is the mean over steps of (greatest -
/// smallest) / median over rounds, the greater one of both sides.
///
/// A change is compared with the drift of the question, which is the median of B/A over all entrants that answer it
/// (the same columns but for mesh, pipeline and variant): they were measured in turn, so that a machine that has become
/// slower, or code that all of them share, changes all of them. The drift of a question is compared with the median of
/// all drifts in the same way, with the greatest tolerance, because hours pass from one scene to the next. Throws
/// InputError for folders without a common entrant, for an invalid record, and for two rows that have the same entrant,
/// step and round.
RecordComparison compare_records(const std::string& folder_a, const std::string& folder_b);

}  // namespace volccd
