// Counts and times of a run. Plain data, always recorded.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <volccd/query/stage.hpp>

namespace volccd {

/// Statistics of one stage of a pipeline. The role of the stage determines what `in` and `out` count: a broad phase
/// outputs element pairs, a flood outputs element pairs and has those that survive culling as input, element culling
/// and initial overlaps have element pairs as input and output, an assignment has element pairs as input and tests as
/// output, an orphan source outputs tests, feature filters have tests as input and output, and a narrow phase has tests
/// as input and contacts as output.
struct StageStatistics {
  std::string role;  ///< as in `--set`: "broad-phase", "element-culling", ...; the last entry may be "initial-overlaps"
  std::string name;  ///< name in the registry
  std::vector<StageCounter> counters = {};  ///< what the stage itself measured (Stage::append_counters)
  std::uint64_t in = 0, out = 0;
  double prepare_seconds = 0;  ///< wall-clock time of prepare()
  /// Time of run() and, of a source of work, of next_round(), summed over workers, without the time of other stages,
  /// idle time and bookkeeping. The time to gather a block of tests is included in the first stage that processes the
  /// block.
  double seconds = 0;

  /// The value of a counter, 0 if there is none with this name.
  double counter(std::string_view which) const;
  double all_seconds() const { return prepare_seconds + seconds; }
};

struct Statistics {
  std::uint64_t steps = 0;
  std::uint64_t list_steps = 0;       ///< steps that made a candidate list; these and those below are not fresh
  std::uint64_t refreshed_steps = 0;  ///< steps that refreshed a candidate list of an earlier step
  std::uint64_t reused_steps = 0;     ///< steps that used a candidate list of an earlier step as it was
  std::uint64_t list_tests = 0;       ///< tests in the lists of all these steps
  double list_budget = 0;             ///< of the list, in the unit of the coordinates; maximum over the steps
  double list_seconds = 0;           ///< part of `seconds`: to make and refresh lists, and to compare motions with them
  std::uint64_t element_pairs = 0;   ///< element pairs that the broad phase emitted
  std::uint64_t adjacent_pairs = 0;  ///< adjacent pairs and self pairs among them; 0 if not requested
  std::uint64_t surviving_pairs = 0;         ///< element pairs after element culling
  std::uint64_t owned_tests = 0;             ///< tests from the assignment
  std::uint64_t orphan_tests = 0;            ///< tests from an orphan source or a flood
  std::uint64_t vf_tests = 0, ee_tests = 0;  ///< elementary tests performed by the narrow phase
  std::uint64_t contacts = 0;
  std::uint64_t contacts_at_start = 0;          ///< contacts with Contact::at_start
  std::uint64_t initial_overlaps = 0;           ///< element pairs listed; 0 if not requested
  std::uint64_t duplicates = 0;                 ///< contacts that were found repeatedly; not included in `contacts`
  std::uint64_t degenerate = 0, undecided = 0;  ///< sums of NarrowCounters
  double earliest_toi = std::numeric_limits<double>::infinity();  ///< of all contacts; infinity if there are none
  double seconds = 0;                   ///< wall-clock time of run(); with one worker, the sum of the stages and a
                                        ///< remainder
  std::size_t workspace_bytes = 0;      ///< maximum over the steps
  std::vector<StageStatistics> stages;  ///< in the order of the pipeline

  /// Number of elementary tests performed.
  std::uint64_t tests() const { return vf_tests + ee_tests; }
  /// Adds the statistics of another step of the same pipeline.
  Statistics& operator+=(const Statistics& other);
};

/// Calls visit(name, value) for each count and time but those of the stages; a value is a std::uint64_t or a double.
/// The names are those in JSON, in Python and in C, and live as long as the program.
template <class Visit>
void visit_values(const Statistics& s, Visit&& visit) {
  visit("steps", s.steps);
  visit("list_steps", s.list_steps);
  visit("refreshed_steps", s.refreshed_steps);
  visit("reused_steps", s.reused_steps);
  visit("list_tests", s.list_tests);
  visit("list_budget", s.list_budget);
  visit("list_seconds", s.list_seconds);
  visit("element_pairs", s.element_pairs);
  visit("adjacent_pairs", s.adjacent_pairs);
  visit("surviving_pairs", s.surviving_pairs);
  visit("owned_tests", s.owned_tests);
  visit("orphan_tests", s.orphan_tests);
  visit("vf_tests", s.vf_tests);
  visit("ee_tests", s.ee_tests);
  visit("contacts", s.contacts);
  visit("contacts_at_start", s.contacts_at_start);
  visit("initial_overlaps", s.initial_overlaps);
  visit("duplicates", s.duplicates);
  visit("degenerate", s.degenerate);
  visit("undecided", s.undecided);
  visit("earliest_toi", s.earliest_toi);
  visit("seconds", s.seconds);
  visit("workspace_bytes", s.workspace_bytes);
}

}  // namespace volccd
