// What a run counted and how long it took. Plain data, always on.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace volccd {

/// One stage of a pipeline. What `in` and `out` count is in the stage's role: the broad phase gives element pairs,
/// element culling and initial overlaps take and give them, the assignment takes element pairs and gives tests, an
/// orphan source gives tests, feature filters take and give tests, the narrow phase takes tests and gives contacts.
struct StageStatistics {
  std::string role;  ///< as in `--set`: "broad-phase", "element-culling", ...; "initial-overlaps" for the last
  std::string name;  ///< as registered
  std::uint64_t in = 0, out = 0;
  double prepare_seconds = 0;  ///< wall clock of prepare()
  double bounds_seconds =
      0;  ///< of these, what a broad phase spent on the bounds of vertices (BroadPhase::bounds_seconds)
  /// Of run(), summed over workers, without what is charged to other stages, without idle time and bookkeeping. The
  /// time to gather a block of tests is charged to the first stage that looks at it.
  double seconds = 0;

  double all_seconds() const { return prepare_seconds + seconds; }
};

struct Statistics {
  std::uint64_t steps = 0;
  std::uint64_t element_pairs = 0;   ///< emitted by the broad phase
  std::uint64_t adjacent_pairs = 0;  ///< of those, adjacent ones and self pairs; 0 where they are not asked for
  std::uint64_t surviving_pairs = 0; ///< after element culling
  std::uint64_t owned_tests = 0;     ///< tests that element pairs gave
  std::uint64_t orphan_tests = 0;    ///< tests that the O-Set gave
  std::uint64_t vf_tests = 0, ee_tests = 0;  ///< elementary tests performed by the narrow phase
  std::uint64_t contacts = 0;
  std::uint64_t contacts_at_start = 0;  ///< of those, with Contact::at_start
  std::uint64_t left_out = 0;  ///< contacts that are not in `contacts` because the request leaves them out
  std::uint64_t initial_overlaps = 0;  ///< element pairs listed; 0 where they are not asked for
  std::uint64_t duplicates = 0;      ///< contacts found again, not in `contacts` nor `left_out`
  std::uint64_t degenerate = 0, undecided = 0;  ///< NarrowCounters
  double earliest_toi = std::numeric_limits<double>::infinity();  ///< of all contacts; infinity without any
  double seconds = 0;                ///< wall clock of run(); with one worker, the stages and a remainder add up to it
  std::size_t workspace_bytes = 0;   ///< largest seen
  std::vector<StageStatistics> stages;  ///< in the order of the pipeline

  /// Elementary tests performed.
  std::uint64_t tests() const { return vf_tests + ee_tests; }
  /// Adds a step of the same pipeline.
  Statistics& operator+=(const Statistics& other);
};

}  // namespace volccd
