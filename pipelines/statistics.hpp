// What a run counted and how long it took. Plain data, always on.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace volccd {

/// One stage of a pipeline. What `in` and `out` count is in the stage's role: element pairs for the broad phase and element
/// culling, tests for feature filters, tests in and contacts out for the narrow phase; feature culling takes element pairs
/// and gives tests; initial overlaps take and give element pairs.
struct StageStatistics {
  std::string role;  ///< "update", "broad-phase", "element-culling", "feature-culling", "orphans", "feature-filter", ...,
                     ///< "initial-overlaps"
  std::string name;
  std::uint64_t in = 0, out = 0;
  double seconds = 0;  ///< summed over workers
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
  std::uint64_t initial_overlaps = 0;  ///< element pairs listed; 0 where they are not asked for
  std::uint64_t duplicates = 0;      ///< contacts found again, not in `contacts`
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
