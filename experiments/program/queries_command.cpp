#include <cstdio>

#include <fmt/format.h>

#include <volccd/experiments/program/commands.hpp>
#include <volccd/experiments/program/progress.hpp>
#include <volccd/experiments/tables/query_comparison.hpp>

namespace volccd {

namespace {

struct QueriesOptions {
  std::string file;
  QuerySourceConfig source;
  QueryComparisonConfig comparison;
  bool json = false, list = false;
};

void print_queries(const char* what, const std::string& narrow_phase, const KnownQueries& queries,
                   const std::vector<std::uint64_t>& indices) {
  for (const std::uint64_t i : indices)
    fmt::print("{} by {}: {} {} {} ({})\n", what, narrow_phase, queries.scene,
               queries.kind == FeatureKind::vf ? "VF" : "EE", i, queries.place(i));
}

void print_lists(const QueryRecord& record, const std::vector<KnownQueries>& groups) {
  fmt::print("\n");
  for (std::size_t g = 0; g < record.groups.size(); ++g)
    for (const QueryScore& score : record.groups[g].scores) {
      print_queries("missed", score.narrow_phase, groups[g], score.missed);
      print_queries("extra", score.narrow_phase, groups[g], score.extra);
    }
}

int run(const QueriesOptions& options, const Registry& registry) {
  const std::vector<KnownQueries> groups = load_queries(options.file, options.source);
  const InterruptGuard guard;
  QueryRecord record;
  {
    std::unique_ptr<Progress> progress;
    QueryComparisonConfig config = options.comparison;
    config.progress = [&](std::size_t done, std::size_t total) {
      if (!progress) progress = std::make_unique<Progress>("testing queries, run", total);
      progress->advance(done);
      return InterruptGuard::interrupted();
    };
    record = compare_on_queries(registry, groups, config);
  }
  record.file = options.file;
  if (options.json) {
    fmt::print("{}\n", record.to_json().dump(2));
  } else {
    fmt::print("{}\n\n{}", options.file, query_table(record));
    if (options.list) print_lists(record, groups);
  }
  if (InterruptGuard::interrupted()) return kInterrupted;
  const std::vector<std::string> broken = record.broken_promises();
  for (const std::string& line : broken) fmt::print(stderr, "volccd: {}\n", line);
  return broken.empty() ? kDone : kDifferent;
}

}  // namespace

void add_queries_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("queries", "narrow phases on elementary tests with known answers");
  const auto options = std::make_shared<QueriesOptions>();
  command->add_option("FILE", options->file, "query file (HDF5), or a sequence: its ground truth")
      ->required()
      ->type_name("");
  command
      ->add_option("--narrowphase", options->comparison.narrow_phases,
                   "name[:option=value...]; several are compared; default: that of VolCCD+")
      ->delimiter(',')
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--filters", options->comparison.filters,
                   "feature filters that run before each, and count in its time")
      ->delimiter(',')
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--set", options->comparison.settings, "stage.option=value; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command->add_flag("--candidates", options->source.candidates,
                    "sequences: all pairs with overlapping swept boxes, not only those that the truth lists");
  command->add_option("--sample", options->source.sample, "at most N of each scene and kind; 0: all")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--rounds", options->comparison.rounds, "timed runs, of which the median counts; 0: no times")
      ->check(CLI::Range(0, 1000))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--list", options->list, "print every query that is missed or extra");
  command->add_flag("--json", options->json, "all of it as JSON")->excludes("--list");
  command->footer(
      "Exit code 1 if a narrow phase whose guarantee is not `approximate` misses a query.\n"
      "Examples:\n"
      "  volccd queries ccd-queries.h5\n"
      "  volccd queries ccd-queries.h5 --narrowphase cubic,cubic:tolerance=1e-6 --list\n"
      "  volccd queries rod-twist.vtkhdf --candidates --filters feature-kdop,coplanarity --json");
  command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
