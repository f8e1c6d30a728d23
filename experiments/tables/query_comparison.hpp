// Narrow phases side by side on tests with known answers: what each misses, what it has too many, and how long it
// takes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/query_source.hpp>
#include <volccd/pipelines/registry.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// One narrow phase on one group of queries.
struct QueryScore {
  std::string narrow_phase;                  ///< as configured: "inclusion", "inclusion:undecided=exact"
  std::vector<std::uint64_t> missed, extra;  ///< queries, by KnownQueries::index; empty where nothing is known
  std::uint64_t contacts = 0, degenerate = 0, undecided = 0;
  std::uint64_t tests = 0;          ///< queries that the filters left
  double earliest = 0, latest = 0;  ///< reported less true time, over queries with a known one: least (<= 0), greatest
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
  std::string stopped_by;  ///< why there are no more groups; empty: these are all

  /// Sums over the groups of a kind, one score for each narrow phase (times by weight), no lists.
  QueryGroupRecord total(FeatureKind kind) const;
  /// A line for each contestant whose guarantee is not `approximate` and that misses queries.
  std::vector<std::string> broken_promises() const;
  nlohmann::json to_json() const;  ///< with machine_facts()
};

struct QueryComparisonConfig {
  /// "name" or "name:option=value[:option=value...]"; empty: the narrow phase of VolCCD+.
  std::vector<std::string> narrow_phases;
  std::vector<std::string> filters;   ///< feature filters before each; likewise
  std::vector<std::string> settings;  ///< "stage.option=value", of whichever of these stages
  int rounds = 5;
  /// Called before each run.
  std::function<void(std::size_t done, std::size_t total)> progress;
  /// Called every few thousand queries; may throw to stop.
  std::function<void()> check;
};

/// Puts the answers of a narrow phase ("name[:option=value...]"), times included, in place of what is known of the
/// queries. `check`: as QueryComparisonConfig's. Throws ConfigError.
void judge(const Registry& registry, const std::string& narrow_phase, KnownQueries& queries,
           const std::function<void()>& check = {});

/// In each group, each narrow phase is run once for its answers; then all in turn, `rounds` times, each run repeated
/// for a millisecond at least. One thread. Groups are added to `record`, each when it is complete: those stay there
/// when this throws, which it does for a ConfigError, or what config.check throws.
void compare_on_queries(const Registry& registry, const std::vector<KnownQueries>& groups,
                        const QueryComparisonConfig& config, QueryRecord& record);

/// A row for each group and narrow phase; totals by kind where there are several groups.
std::string query_table(const QueryRecord& record);

}  // namespace volccd
