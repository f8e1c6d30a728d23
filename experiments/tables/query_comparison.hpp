// Comparison of narrow phases on tests with known answers: the contacts that each misses or reports in excess, and its
// time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/query_source.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/pipelines/registry.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// One narrow phase on one group of queries.
struct QueryScore {
  std::string narrow_phase;                  ///< as configured: "inclusion", "inclusion:undecided=exact"
  std::vector<std::uint64_t> missed, extra;  ///< queries, by KnownQueries::index; empty if no answers are known
  std::uint64_t contacts = 0, degenerate = 0, undecided = 0;
  std::uint64_t tests = 0;          ///< queries that the filters kept
  double earliest = 0, latest = 0;  ///< least (<= 0) and greatest reported minus true time, where known
  double nanoseconds = 0;           ///< for each query, filters included: median over the rounds
};

struct QueryGroupRecord {
  std::string scene;
  FeatureKind kind;
  std::uint64_t queries = 0, colliding = 0;
  bool known = false;              ///< whether answers are known
  std::vector<QueryScore> scores;  ///< in the order of the narrow phases
};

struct QueryRecord {
  struct Contestant {
    std::string name;
    Guarantee guarantee;  ///< of the narrow phase and the filters
  };
  std::string file;
  int rounds = 0;
  std::vector<std::string> filters;
  std::vector<Contestant> narrow_phases;
  std::vector<QueryGroupRecord> groups;
  std::string stopped_by;  ///< why further groups are missing; empty: there are none

  /// Sums over the groups of a kind: one score for each narrow phase, with weighted mean times and without lists.
  QueryGroupRecord total(FeatureKind kind) const;
  /// One line for each narrow phase that misses queries although its guarantee is not `approximate`.
  std::vector<std::string> broken_promises() const;
  nlohmann::json to_json() const;  ///< with machine_facts()
};

struct QueryComparisonConfig {
  /// "name" or "name:option=value[:option=value...]"; empty: the narrow phase of VolCCD+.
  std::vector<std::string> narrow_phases;
  std::vector<std::string> filters;   ///< feature filters before each narrow phase, in the same form
  std::vector<std::string> settings;  ///< "stage.option=value", for any of these stages
  int rounds = 5;
  /// Called before each run.
  std::function<void(std::size_t done, std::size_t total)> progress;
  /// Called every few thousand queries; may throw to stop.
  std::function<void()> check;
};

/// Replaces the known answers of the queries by those of a narrow phase ("name[:option=value...]"), times included.
/// `check`: as in QueryComparisonConfig. Throws ConfigError.
void judge(const Registry& registry, const std::string& narrow_phase, KnownQueries& queries,
           const std::function<void()>& check = {});

/// In each group, each narrow phase runs once for its answers; then all run alternately, `rounds` times, where each run
/// is repeated for at least a millisecond. Runs on one thread. Each group is added to `record` when it is complete, and
/// remains there if this function throws. Throws ConfigError, and what config.check throws.
void compare_on_queries(const Registry& registry, const std::vector<KnownQueries>& groups,
                        const QueryComparisonConfig& config, QueryRecord& record);

/// A table with one row for each group and narrow phase, and totals by kind if there are several groups.
std::string query_table(const QueryRecord& record, std::size_t width = kTextWidth);

}  // namespace volccd
