#include <volccd/core/suggest.hpp>
#include <volccd/experiments/tables/query_comparison.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include <volccd/core/median.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/pipelines/test_chain.hpp>

namespace volccd {

using nlohmann::json;

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kMinRun = 1e-3;  ///< seconds; long enough that the time to read the clock is negligible
constexpr std::size_t kBatch = 4096;

/// Parses "name:option=value:...".
StageChoice parse_choice(const std::string& text) {
  StageChoice choice;
  std::string_view rest = text;
  const auto next = [&rest] {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const std::string part(rest.substr(0, colon));
    rest.remove_prefix(std::min(colon + 1, rest.size()));
    return part;
  };
  choice.name = next();
  while (!rest.empty()) {
    const std::string part = next();
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0)
      throw ConfigError(fmt::format("'{}' is not name:option=value", text));
    choice.options[part.substr(0, equals)] = part.substr(equals + 1);
  }
  return choice;
}

std::string text_of(const StageChoice& choice) {
  std::string text = choice.name;
  for (const auto& [option, value] : choice.options) text += fmt::format(":{}={}", option, value);
  return text;
}

struct Choices {
  std::vector<StageChoice> narrow_phases, filters;

  void apply(const std::string& setting) {
    const std::size_t equals = setting.find('='), dot = setting.find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot > equals)
      throw ConfigError(fmt::format("'{}' is not stage.option=value", setting));
    const std::string stage = setting.substr(0, dot);
    bool found = false;
    std::string known;
    for (std::vector<StageChoice>* list : {&narrow_phases, &filters})
      for (StageChoice& choice : *list) {
        known += (known.empty() ? "" : ", ") + choice.name;
        if (choice.name != stage) continue;
        choice.options[setting.substr(dot + 1, equals - dot - 1)] = setting.substr(equals + 1);
        found = true;
      }
    if (!found)
      throw ConfigError(fmt::format("no stage '{}' is run; there are {}{}", stage, known, did_you_mean(stage, known)));
  }
};

Choices choices_of(const Registry& registry, const QueryComparisonConfig& config) {
  Choices choices;
  for (const std::string& text : config.narrow_phases) choices.narrow_phases.push_back(parse_choice(text));
  if (choices.narrow_phases.empty()) choices.narrow_phases.push_back(registry.pipeline("VolCCD+").narrow_phase);
  for (const std::string& text : config.filters) choices.filters.push_back(parse_choice(text));
  for (const std::string& setting : config.settings) choices.apply(setting);
  return choices;
}

template <class Stage>
std::unique_ptr<Stage> make_stage(const Registry& registry, const StageChoice& choice) {
  try {
    return registry.stage<Stage>(choice.name).make(choice.options);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("stage {}: {}", choice.name, error.what()));
  }
}

using Filters = std::vector<std::unique_ptr<FeatureFilter>>;

/// A narrow phase behind the filters, with the buffers that a run needs.
class QueryContestant {
 public:
  QueryContestant(std::unique_ptr<NarrowPhase> narrow, const Filters& filters, const std::function<void()>& check)
      : narrow_(std::move(narrow)),
        check_(check),
        stages_{filters, *narrow_, states_},
        statistics_(filters.size() + 1) {
    for (const auto& filter : filters) states_.push_back(filter->make_state());
    states_.push_back(narrow_->make_state());
    stages_.states = states_;
  }

  /// Runs the queries in batches, as a pipeline does.
  void run(const KnownQueries& queries) {
    SerialExecutor executor;
    for (std::size_t i = 0; i < stages_.filters.size(); ++i)
      stages_.filters[i]->prepare(queries.step, *states_[i], executor);
    if (!stages_.filters.empty()) stages_.filters[0]->prepare_select(queries.step, *states_[0], executor);
    narrow_->prepare(queries.step, *states_.back(), executor);
    chain_.start(queries.step, stages_, statistics_, 0);
    for (std::size_t begin = 0; begin < queries.size(); begin += kBatch) {
      if (check_) check_();
      const auto batch = std::span(queries.pairs).subspan(begin, std::min(kBatch, queries.size() - begin));
      tests_.assign(batch.begin(), batch.end());
      chain_.add(queries.kind, tests_);
    }
    chain_.finish();
  }

  double seconds_of_run(const KnownQueries& queries) {
    const Clock::time_point start = Clock::now();
    for (double runs = 1;; ++runs) {
      run(queries);
      const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
      if (elapsed >= kMinRun) return elapsed / runs;
    }
  }

  /// The contacts of the last run.
  const std::vector<Contact>& contacts() const { return chain_.contacts(); }
  const NarrowCounters& counters() const { return chain_.counters(); }
  std::uint64_t tests() const { return chain_.tests(FeatureKind::vf) + chain_.tests(FeatureKind::ee); }

 private:
  std::unique_ptr<NarrowPhase> narrow_;
  const std::function<void()>& check_;
  std::vector<std::unique_ptr<StageState>> states_;
  TestStages stages_;
  std::vector<StageStatistics> statistics_;
  TestChain chain_;
  std::vector<FeaturePair> tests_;
};

/// The contact of each query, or null if it has none, in the contestant's last run. `contacts` are in the order of the
/// pairs.
std::vector<const Contact*> contacts_by_query(const std::string& name, const KnownQueries& queries,
                                              const std::vector<Contact>& contacts) {
  std::vector<const Contact*> found(queries.size(), nullptr);
  std::size_t next = 0;
  for (std::size_t i = 0; i < queries.size() && next < contacts.size(); ++i)
    if (contacts[next].vertices == test_vertices(queries.step.features(), queries.kind, queries.pairs[i]))
      found[i] = &contacts[next++];
  if (next != contacts.size())
    throw Error(fmt::format("narrow phase {} reports contacts of other pairs, or not in their order", name));
  return found;
}

/// Compares the contacts of the last run with the known answer of each query.
QueryScore score(const std::string& name, const KnownQueries& queries, const QueryContestant& contestant) {
  QueryScore result;
  result.narrow_phase = name;
  result.contacts = contestant.contacts().size();
  result.degenerate = contestant.counters().degenerate;
  result.undecided = contestant.counters().undecided;
  result.tests = contestant.tests();
  const std::vector<const Contact*> found = contacts_by_query(name, queries, contestant.contacts());
  if (queries.collides.empty()) return result;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (queries.collides[i] && !found[i]) result.missed.push_back(queries.index[i]);
    if (!queries.collides[i] && found[i]) result.extra.push_back(queries.index[i]);
    if (!found[i] || queries.toi.empty() || std::isnan(queries.toi[i])) continue;
    result.earliest = std::min(result.earliest, found[i]->toi - queries.toi[i]);
    result.latest = std::max(result.latest, found[i]->toi - queries.toi[i]);
  }
  return result;
}

json group_json(const QueryGroupRecord& group, bool lists) {
  json scores = json::array();
  for (const QueryScore& s : group.scores) {
    json entry = {{"narrow_phase", s.narrow_phase},
                  {"contacts", s.contacts},
                  {"tests", s.tests},
                  {"degenerate", s.degenerate},
                  {"undecided", s.undecided},
                  {"earliest", s.earliest},
                  {"latest", s.latest},
                  {"nanoseconds", s.nanoseconds}};
    entry["missed"] = group.known ? json(s.missed.size()) : json(nullptr);
    entry["extra"] = group.known ? json(s.extra.size()) : json(nullptr);
    if (lists) entry["missed_queries"] = s.missed, entry["extra_queries"] = s.extra;
    scores.push_back(std::move(entry));
  }
  return {{"scene", group.scene},
          {"kind", group.kind == FeatureKind::vf ? "VF" : "EE"},
          {"queries", group.queries},
          {"colliding", group.known ? json(group.colliding) : json(nullptr)},
          {"scores", scores}};
}

}  // namespace

QueryGroupRecord QueryRecord::total(FeatureKind kind) const {
  QueryGroupRecord sum{"all", kind, 0, 0, true, {}};
  for (const Contestant& contestant : narrow_phases) sum.scores.emplace_back().narrow_phase = contestant.name;
  for (const QueryGroupRecord& group : groups) {
    if (group.kind != kind) continue;
    sum.queries += group.queries;
    sum.colliding += group.colliding;
    sum.known = sum.known && group.known;
    for (std::size_t i = 0; i < sum.scores.size(); ++i) {
      QueryScore& s = sum.scores[i];
      const QueryScore& one = group.scores[i];
      s.missed.insert(s.missed.end(), one.missed.begin(), one.missed.end());
      s.extra.insert(s.extra.end(), one.extra.begin(), one.extra.end());
      s.contacts += one.contacts, s.tests += one.tests;
      s.degenerate += one.degenerate, s.undecided += one.undecided;
      s.earliest = std::min(s.earliest, one.earliest);
      s.latest = std::max(s.latest, one.latest);
      s.nanoseconds += one.nanoseconds * static_cast<double>(group.queries);
    }
  }
  for (QueryScore& s : sum.scores) s.nanoseconds /= std::max<double>(1, static_cast<double>(sum.queries));
  return sum;
}

std::vector<std::string> QueryRecord::broken_promises() const {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < narrow_phases.size(); ++i) {
    if (narrow_phases[i].guarantee == Guarantee::approximate) continue;
    std::size_t missed = 0;
    for (const QueryGroupRecord& group : groups) missed += group.scores[i].missed.size();
    if (missed > 0)
      lines.push_back(
          fmt::format("{} is {}, but misses {}", narrow_phases[i].name, to_string(narrow_phases[i].guarantee), missed));
  }
  return lines;
}

json QueryRecord::to_json() const {
  json list = json::array(), contestants = json::array();
  for (const QueryGroupRecord& group : groups) list.push_back(group_json(group, true));
  for (const Contestant& contestant : narrow_phases)
    contestants.push_back({{"name", contestant.name}, {"guarantee", to_string(contestant.guarantee)}});
  return {{"file", file},
          {"complete", stopped_by.empty()},
          {"stopped_by", stopped_by.empty() ? json(nullptr) : json(stopped_by)},
          {"rounds", rounds},
          {"machine", machine_facts()},
          {"feature_filters", filters},
          {"narrow_phases", contestants},
          {"groups", list},
          {"total", {group_json(total(FeatureKind::vf), false), group_json(total(FeatureKind::ee), false)}}};
}

void judge(const Registry& registry, const std::string& narrow_phase, KnownQueries& queries,
           const std::function<void()>& check) {
  const Filters none;
  QueryContestant contestant(make_stage<NarrowPhase>(registry, parse_choice(narrow_phase)), none, check);
  contestant.run(queries);
  queries.collides.assign(queries.size(), 0);
  queries.toi.assign(queries.size(), std::numeric_limits<double>::quiet_NaN());
  const std::vector<const Contact*> found = contacts_by_query(narrow_phase, queries, contestant.contacts());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (!found[i]) continue;
    queries.collides[i] = 1;
    queries.toi[i] = found[i]->toi;
  }
}

void compare_on_queries(const Registry& registry, const std::vector<KnownQueries>& groups,
                        const QueryComparisonConfig& config, QueryRecord& record) {
  const Choices choices = choices_of(registry, config);
  record.rounds = config.rounds;
  record.filters.clear();
  record.narrow_phases.clear();
  Guarantee filter_guarantee = Guarantee::exact;
  Filters filters;
  for (const StageChoice& choice : choices.filters) {
    filters.push_back(make_stage<FeatureFilter>(registry, choice));
    filter_guarantee = weakest(filter_guarantee, registry.stage<FeatureFilter>(choice.name).guarantee);
    record.filters.push_back(text_of(choice));
  }
  std::deque<QueryContestant> contestants;  // a deque, because contestants must keep their addresses
  for (const StageChoice& choice : choices.narrow_phases) {
    contestants.emplace_back(make_stage<NarrowPhase>(registry, choice), filters, config.check);
    record.narrow_phases.push_back(
        {text_of(choice), weakest(filter_guarantee, registry.stage<NarrowPhase>(choice.name).guarantee)});
  }
  const std::size_t total = groups.size() * contestants.size() * (1 + static_cast<std::size_t>(config.rounds));
  std::size_t done = 0;
  const auto advance = [&] {
    if (config.progress) config.progress(done, total);
    ++done;
  };
  for (const KnownQueries& queries : groups) {
    QueryGroupRecord group{queries.scene, queries.kind, queries.size(), 0, !queries.collides.empty(), {}};
    for (const std::uint8_t collides : queries.collides) group.colliding += collides;
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      advance();
      contestants[i].run(queries);
      group.scores.push_back(score(record.narrow_phases[i].name, queries, contestants[i]));
    }
    std::vector<std::vector<double>> seconds(contestants.size());
    for (int round = 0; round < config.rounds; ++round)
      for (std::size_t i = 0; i < contestants.size(); ++i) {
        advance();
        seconds[i].push_back(contestants[i].seconds_of_run(queries));
      }
    for (std::size_t i = 0; i < contestants.size(); ++i)
      group.scores[i].nanoseconds = 1e9 * median(seconds[i]) / static_cast<double>(queries.size());
    record.groups.push_back(std::move(group));
  }
}

std::string query_table(const QueryRecord& record, std::size_t width) {
  std::vector<std::string> header = {"scene",  "kind",  "queries",   "colliding", "narrow phase", "contacts",
                                     "missed", "extra", "undecided", "early",     "late",         "ns/query"};
  if (!record.filters.empty()) header.insert(header.begin() + 5, "tests");
  TextTable table(header);
  const auto add = [&](const QueryGroupRecord& group) {
    for (const QueryScore& s : group.scores) {
      const bool first = &s == &group.scores.front();
      const auto known = [&](std::uint64_t n) { return group.known ? grouped(n) : std::string("-"); };
      const auto time = [](double error) {
        return error == 0 ? std::string("-") : fmt::format("{:.1e}", std::abs(error));
      };
      std::vector<std::string> row = {first ? group.scene : "",
                                      first ? (group.kind == FeatureKind::vf ? "VF" : "EE") : "",
                                      first ? grouped(group.queries) : "",
                                      first ? known(group.colliding) : "",
                                      s.narrow_phase,
                                      grouped(s.contacts),
                                      known(s.missed.size()),
                                      known(s.extra.size()),
                                      grouped(s.undecided),
                                      time(s.earliest),
                                      time(s.latest),
                                      record.rounds > 0 ? fmt::format("{:.1f}", s.nanoseconds) : "-"};
      if (!record.filters.empty()) row.insert(row.begin() + 5, grouped(s.tests));
      table.add(std::move(row));
    }
  };
  for (const QueryGroupRecord& group : record.groups) add(group);
  if (record.groups.size() > 2) {
    table.rule();
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      if (const QueryGroupRecord sum = record.total(kind); sum.queries > 0) add(sum);
  }
  return table.text(width);
}

}  // namespace volccd
