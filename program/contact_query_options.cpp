#include <volccd/program/contact_query_options.hpp>

#include <cstdio>
#include <limits>

#include <fmt/format.h>

namespace volccd {

void ContactQueryOptions::add_to(CLI::App& command) {
  sequence.add_to(command);
  command.add_option("--pipeline", pipeline, "see `volccd stages`")->type_name("NAME")->capture_default_str();
  command.add_option("--set", settings, "stage.option=value, or role=stage[,stage...]; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command.add_option("--contacts", contacts, "write the contacts as CSV")->type_name("FILE");
  command
      .add_option("--overlaps", overlaps,
                  "also find the elements that overlap at the start of a step, and write them as CSV")
      ->type_name("FILE");
  command.add_option("--stats", stats, "write counts and times as JSON")->type_name("FILE");
  command.add_flag("--first", first, "find only the earliest contact of each step, which is faster");
  command
      .add_option("--substeps", substeps,
                  "divide each motion into N steps; steps in files are then numbered N k to N k + N - 1")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command
      .add_option(
          "--lists", lists,
          "test the candidates of earlier steps: off; auto, where that is faster; or with a budget (a distance) "
          "and a number of steps ahead; the contacts are the same; default: auto with --substeps, off without")
      ->type_name("off|auto|B:N");
  query.add_to(command);
  sequence.add_objects_to(command);
}

Request ContactQueryOptions::request() const {
  return {.query = first ? Query::first : Query::all, .initial_overlaps = !overlaps.empty()};
}

/// "off", "auto", or a budget and a number of steps, "B:N".
ListConfig ContactQueryOptions::list_config() const {
  if (lists == "off" || (lists.empty() && substeps == 1)) return {};
  if (lists == "auto" || lists.empty()) return {.use = ListConfig::Use::automatic};
  ListConfig config{.use = ListConfig::Use::always};
  char rest = 0;
  if (std::sscanf(lists.c_str(), "%lf:%lf%c", &config.budget, &config.steps, &rest) != 2)
    throw ConfigError(fmt::format("--lists: '{}' is not off, auto, or BUDGET:STEPS, such as 0.001:20", lists));
  return config;
}

/// Frames of a file are so far apart that a skin makes more copies than it saves lists.
distributed::Config ContactQueryOptions::rank_config(Executor& executor) const {
  distributed::Config config{.executor = &executor,
                             .filter = query.filter(),
                             .leave_out_shell_neighbours = query.leaves_out_shell_neighbours(sequence),
                             .lists = list_config()};
  if (substeps == 1) config.skin = 0;
  return config;
}

void ContactQueryOptions::check_numbers(const StepRange& steps) const {
  if (steps.end > std::numeric_limits<int>::max() / substeps)
    throw ConfigError(
        fmt::format("--substeps: {} substeps of {} motions are more than can be numbered", substeps, steps.end));
}

}  // namespace volccd
