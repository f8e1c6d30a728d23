#include <volccd/experiments/tables/substeps.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

using nlohmann::json;

namespace {

constexpr double kSeparation = 0.02;  ///< in mean edges of the scene at its start
constexpr int kWarmUps = 20;          ///< at most this many substeps of the motion before a window run, the last ones

std::vector<int> numbers_of_substeps(const TableScene& scene, bool full) {
  return full && !scene.large ? std::vector{1, 10, 100, 1000} : std::vector{1, 10, 100};
}

/// How many substeps of a motion run fresh at most, the first ones; with lists all of them run.
int max_fresh_substeps(const TableScene& scene, bool full) { return scene.large && !full ? 20 : 100; }

/// One motion of 1000 substeps takes as long as ten of 100. In ten substeps, a list serves one motion: several show
/// what lists cost in the long run, after the first, which needs no credit.
std::vector<StepWindow> windows_of(const TableScene& scene, int substeps, bool full) {
  const bool one = substeps == 1000 || (scene.large && !full);
  return sampled_windows(step_count(scene.file), full && !one ? 2 : 1,
                         one                              ? 1
                         : substeps == 10 && !scene.large ? 8
                                                          : 2);
}

/// The contacts of a substep.
struct Found {
  std::size_t contacts;
  std::string hash;
};

/// What a runner did in the substeps of one motion.
struct Run {
  Statistics total;
  /// Parts of total.list_seconds: in substeps that make a list, and in those that refresh one. The rest is to compare
  /// motions with lists.
  double making_seconds = 0, refreshing_seconds = 0;
  std::vector<Found> found;  ///< of each substep that ran

  double per_substep(double sum) const { return sum / static_cast<double>(found.size()); }
};

/// One scene, with its motions divided in one way.
class SubstepComparison {
 public:
  /// `check` is called before each substep, and may throw.
  SubstepComparison(const PlanContext& context, const TableScene& scene, int substeps, std::function<void()> check)
      : registry_(context.registry),
        executor_(context.executor ? *context.executor : serial_executor()),
        scene_(scene),
        substeps_(substeps),
        fresh_substeps_(std::min(substeps, max_fresh_substeps(scene, context.full))),
        check_(std::move(check)),
        reader_(scene.file),
        config_(table_config(scene.file)) {
    SequenceStepper stepper(reader_, config_);
    stepper.go_to(0, executor_);
    separation_ = kSeparation * mean_edge_length(stepper.topology().features(), stepper.motion());
  }

  /// A row for each motion of the window. New runners begin with the end of the motion before the window, which is not
  /// measured.
  std::vector<json> run_round(const StepWindow& window, int round) {
    SequenceStepper stepper(reader_, config_);
    StepRunner fresh = runner({}), with_lists = runner({.use = ListConfig::Use::automatic});
    std::vector<json> rows;
    for (int k = -1; k < window.count; ++k) {
      stepper.go_to(std::max(window.first + k, 0), executor_);
      const int first = k < 0 ? std::max(0, substeps_ - kWarmUps) : 0,
                end_of_fresh = k < 0 ? substeps_ : fresh_substeps_;
      Run of_fresh, of_lists;
      if ((round + k) % 2 == 0) of_fresh = run(stepper, fresh, first, end_of_fresh);
      of_lists = run(stepper, with_lists, first, substeps_);
      if (of_fresh.found.empty()) of_fresh = run(stepper, fresh, first, end_of_fresh);
      expect_same_contacts(of_fresh, of_lists, stepper.current(), first);
      if (k < 0) continue;
      rows.push_back(columns_of(of_fresh, of_lists));
      rows.back().update({{"scene", scene_.name},
                          {"substeps", substeps_},
                          {"step", stepper.current()},
                          {"window", window.first},
                          {"round", round},
                          {"threads", executor_.workers()},
                          {"elements", stepper.topology().mesh().element_count()},
                          {"separation", separation_},
                          {"fresh_bytes", fresh.workspace_bytes()},
                          {"list_bytes", with_lists.workspace_bytes()}});
    }
    return rows;
  }

 private:
  StepRunner runner(ListConfig lists) const {
    return StepRunner(Pipeline(registry_, registry_.pipeline("VolCCD+")),
                      {.executor = &executor_,
                       .separation = separation_,
                       .leave_out_shell_neighbours = config_.shells == ShellModel::solid,
                       .lists = lists});
  }

  /// Runs the substeps [first, end) of the present motion.
  Run run(const SequenceStepper& stepper, StepRunner& runner, int first, int end) {
    const Request request = {.count_adjacent = false};
    Run result;
    for (int i = first; i < end; ++i) {
      check_();
      part_.set_part(stepper.motion(), static_cast<double>(i) / substeps_, static_cast<double>(i + 1) / substeps_);
      const StepResult& step = runner.run(stepper.topology(), part_, request);
      result.total += step.statistics;
      if (step.statistics.list_steps > 0) result.making_seconds += step.statistics.list_seconds;
      if (step.statistics.refreshed_steps > 0) result.refreshing_seconds += step.statistics.list_seconds;
      result.found.push_back({step.contacts.size(), contacts_hash(step.contacts)});
    }
    return result;
  }

  void expect_same_contacts(const Run& fresh, const Run& with_lists, int step, int first) const {
    for (std::size_t i = 0; i < fresh.found.size(); ++i) {
      const Found &a = fresh.found[i], &b = with_lists.found[i];
      if (a.hash == b.hash) continue;
      throw Error(fmt::format(
          "substeps, {}, step {}, substep {} of {}, separation {}: VolCCD+ finds {} contacts without candidate lists "
          "and {} with them, and they are not the same: a list or a stage loses or invents contacts",
          scene_.name, step, first + static_cast<int>(i), substeps_, separation_, a.contacts, b.contacts));
    }
  }

  static json columns_of(const Run& fresh, const Run& with_lists) {
    const Statistics& total = with_lists.total;
    return {{"fresh_s", fresh.per_substep(fresh.total.seconds)},
            {"list_s", with_lists.per_substep(total.seconds)},
            {"making_s", with_lists.per_substep(with_lists.making_seconds)},
            {"refreshing_s", with_lists.per_substep(with_lists.refreshing_seconds)},
            {"comparing_s",
             with_lists.per_substep(total.list_seconds - with_lists.making_seconds - with_lists.refreshing_seconds)},
            {"fresh_substeps", fresh.found.size()},
            {"reused_steps", total.reused_steps},
            {"refreshed_steps", total.refreshed_steps},
            {"list_steps", total.list_steps},
            {"list_tests", total.list_tests},
            {"contacts", with_lists.per_substep(static_cast<double>(total.contacts))}};
  }

  const Registry& registry_;
  Executor& executor_;
  const TableScene& scene_;
  const int substeps_, fresh_substeps_;
  const std::function<void()> check_;
  SequenceReader reader_;
  const SequenceStepper::Config config_;
  double separation_ = 0;
  Motion part_;
};

/// Median and extremes over the rounds.
struct Spread {
  double median, min, max;

  std::string range(const char* unit = "") const {
    return fmt::format("{}-{}{}", number_text(min), number_text(max), unit);
  }
};

/// The spread of a value that is computed from the rows of one round.
template <class Value>
Spread over_rounds(const Rows& rows, Value&& value) {
  std::vector<double> values;
  for (const Rows& round : rows.groups({"round"})) values.push_back(value(round));
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  return {median(values), *min, *max};
}

/// One scene with one number of substeps.
struct Group {
  json scene, substeps;
  Rows rows;

  Spread ms(const char* column) const {
    return over_rounds(rows, [&](const Rows& round) { return round.mean_ms({column}); });
  }
  Spread speedup() const {
    return over_rounds(rows, [](const Rows& round) { return round.mean_ms({"fresh_s"}) / round.mean_ms({"list_s"}); });
  }
  /// Mean over the motions.
  double mean(const char* column) const { return rows.sum(column) / static_cast<double>(rows.steps()); }
  /// In all substeps.
  double share(const char* column) const { return mean(column) / substeps.get<double>(); }
  double listed_share() const { return share("reused_steps") + share("refreshed_steps") + share("list_steps"); }
  double fresh_share() const { return std::max(0.0, 1 - listed_share()); }
  /// Mean over the substeps that have a list.
  double list_tests() const {
    return listed_share() > 0 ? mean("list_tests") / (listed_share() * substeps.get<double>()) : 0;
  }
};

std::vector<Group> groups_of(const Rows& rows) {
  std::vector<Group> groups;
  for (const Rows& some : rows.groups({"scene", "substeps"}))
    groups.push_back({some.value("scene"), some.value("substeps"), some});
  return groups;
}

std::string number(double value) { return number_text(value); }
std::string whole_number(double value) { return grouped(static_cast<std::uint64_t>(value + 0.5)); }

/// A table with a rule between scenes. `cells` returns those of a group after its labels.
template <class Cells>
TextTable table_of(const std::vector<Group>& groups, std::vector<std::string> header, Cells&& cells) {
  header.insert(header.begin(), {"scene", "substeps"});
  TextTable table(std::move(header), 2);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (i > 0 && groups[i].scene != groups[i - 1].scene) table.rule();
    std::vector<std::string> row = cells(groups[i]);
    row.insert(row.begin(), {groups[i].scene.get<std::string>(), groups[i].substeps.dump()});
    table.add(std::move(row));
  }
  return table;
}

TitledTable time_table(const std::vector<Group>& groups) {
  const TextTable table =
      table_of(groups, {"fresh, ms", "fresh range, ms", "lists, ms", "lists range, ms", "fresh / lists", "range"},
               [](const Group& group) {
                 const Spread fresh = group.ms("fresh_s"), lists = group.ms("list_s"), speedup = group.speedup();
                 return std::vector{number(fresh.median),       fresh.range(),     number(lists.median), lists.range(),
                                    ratio_text(speedup.median), speedup.range("x")};
               });
  return {"Time of a substep of VolCCD+", table,
          fmt::format("fresh: without candidate lists; lists: with automatic ones, their cost included; means over the "
                      "substeps of some motions; medians and ranges over rounds; separation: {:g} of the mean "
                      "edge of the scene at its start; contacts of both are the same, compared in each substep that "
                      "both ran\n",
                      kSeparation)};
}

TitledTable use_table(const std::vector<Group>& groups) {
  const TextTable table =
      table_of(groups,
               {"run fresh", "contacts", "reused", "refreshed", "made", "fresh", "tests", "lists", "making, ms",
                "refreshing, ms", "comparing, ms", "memory", "with lists"},
               [](const Group& group) {
                 return std::vector{whole_number(group.mean("fresh_substeps")),
                                    whole_number(group.mean("contacts")),
                                    percent_text(group.share("reused_steps")),
                                    percent_text(group.share("refreshed_steps")),
                                    percent_text(group.share("list_steps")),
                                    percent_text(group.fresh_share()),
                                    whole_number(group.list_tests()),
                                    number(group.mean("list_steps")),
                                    number(group.ms("making_s").median),
                                    number(group.ms("refreshing_s").median),
                                    number(group.ms("comparing_s").median),
                                    memory(static_cast<std::size_t>(group.rows.median("fresh_bytes"))),
                                    memory(static_cast<std::size_t>(group.rows.median("list_bytes")))};
               });
  return {
      "What the lists were used for", table,
      "run fresh: the first substeps of each motion that are run without lists, while all are run with lists; "
      "contacts: of a substep; reused, refreshed, made, fresh: substeps that used a list of an earlier one as it was, "
      "refreshed one, made one, ran without; tests: in a list, mean over the substeps that have one; lists: made in "
      "a motion; making, refreshing, comparing: time of lists in substeps that made one, that refreshed one, and in "
      "the others; memory: of the workspaces\n"};
}

/// Adds KEY, KEY_min and KEY_max.
void add_spread(json& object, const std::string& key, const Spread& spread) {
  object[key] = spread.median;
  object[key + "_min"] = spread.min;
  object[key + "_max"] = spread.max;
}

}  // namespace

ExperimentPlan substeps_plan(const PlanContext& context) {
  ExperimentPlan plan{"substeps", context.full ? "full" : "quick", context.full ? kFullRounds : 3, {}};
  for (const TableScene& scene : table_and_large_scenes(context)) plan.runs.push_back({scene.name, scene.file});
  return plan;
}

void substeps_rows(const PlanContext& context, RecordFile& record) {
  const std::vector<TableScene> scenes = table_and_large_scenes(context);
  if (scenes.empty()) throw ConfigError("substeps: none of its scenes is available");
  const int rounds = substeps_plan(context).rounds;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const auto check = [&] {
      if (context.progress) context.progress(s, scenes.size());
    };
    for (const int substeps : numbers_of_substeps(scenes[s], context.full)) {
      SubstepComparison comparison(context, scenes[s], substeps, check);
      for (const StepWindow& window : windows_of(scenes[s], substeps, context.full))
        for (int round = 0; round < rounds; ++round) {
          const std::string part =
              fmt::format("{} in {}, from step {}, round {}", scenes[s].name, substeps, window.first, round);
          if (!record.has(part)) record.add(part, comparison.run_round(window, round));
        }
    }
  }
}

std::vector<TitledTable> substeps_tables(const json& record) {
  const std::vector<Group> groups = groups_of(Rows(record));
  return {time_table(groups), use_table(groups)};
}

json substeps_summary(const json& record) {
  json summary = json::array();
  for (const Group& group : groups_of(Rows(record))) {
    json object = {{"scene", group.scene},
                   {"substeps", group.substeps},
                   {"elements", group.rows.median("elements")},
                   {"steps", group.rows.steps()},
                   {"fresh_substeps", group.mean("fresh_substeps")},
                   {"threads", group.rows.front().at("threads")},
                   {"separation", group.rows.front().at("separation")},
                   {"contacts", group.mean("contacts")},
                   {"reused_share", group.share("reused_steps")},
                   {"refreshed_share", group.share("refreshed_steps")},
                   {"list_share", group.share("list_steps")},
                   {"fresh_share", group.fresh_share()},
                   {"list_tests", group.list_tests()},
                   {"lists", group.mean("list_steps")},
                   {"making_ms", group.ms("making_s").median},
                   {"refreshing_ms", group.ms("refreshing_s").median},
                   {"comparing_ms", group.ms("comparing_s").median},
                   {"fresh_bytes", group.rows.median("fresh_bytes")},
                   {"list_bytes", group.rows.median("list_bytes")}};
    add_spread(object, "fresh_ms", group.ms("fresh_s"));
    add_spread(object, "list_ms", group.ms("list_s"));
    add_spread(object, "speedup", group.speedup());
    summary.push_back(std::move(object));
  }
  return summary;
}

}  // namespace volccd
