#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/query_comparison.hpp>
#include <volccd/io/sequence/query_file.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

struct QueriesOptions {
  SequenceOptions sequence;
  QuerySourceConfig source;
  QueryComparisonConfig comparison;
  ReportOptions report;
  std::string judge;
  bool list = false;
};

void print_queries(const char* what, const std::string& narrow_phase, const KnownQueries& queries,
                   const std::vector<std::uint64_t>& indices) {
  for (const std::uint64_t i : indices)
    fmt::print("{} by {}: {} {} {} ({})\n", what, narrow_phase, queries.scene,
               queries.kind == FeatureKind::vf ? "VF" : "EE", i, queries.place(i));
}

void print_lists(const QueryRecord& record, const std::vector<KnownQueries>& groups) {
  for (std::size_t g = 0; g < record.groups.size(); ++g)
    for (const QueryScore& score : record.groups[g].scores) {
      print_queries("missed", score.narrow_phase, groups[g], score.missed);
      print_queries("extra", score.narrow_phase, groups[g], score.extra);
    }
}

/// The steps that the options select; a query file counts as one step.
StepRange steps_of(const QueriesOptions& options) {
  const std::string& file = options.sequence.file;
  if (!is_sequence_file(file)) {
    if (!options.sequence.steps.empty()) throw ConfigError("--steps: is for sequences, not for a query file");
    return {0, 1};
  }
  SequenceReader reader(file);
  // The known answers belong to the first step.
  const std::string steps = options.sequence.steps.empty() && !options.source.candidates ? "0" : options.sequence.steps;
  return parse_steps(steps, reader.frame_count() - 1, file);
}

/// Adds the groups of one step, or of a query file, to `record`. `advance` is called with the completed fraction.
template <class Advance>
void compare_on_step(const QueriesOptions& options, const Registry& registry, int step, Advance&& advance,
                     QueryRecord& record) {
  QuerySourceConfig source = options.source;
  source.step = step;
  source.stepper = options.sequence.config;
  source.check = InterruptGuard::check;
  std::vector<KnownQueries> groups = load_queries(options.sequence.file, source);
  if (!options.judge.empty())
    for (KnownQueries& queries : groups) judge(registry, options.judge, queries, InterruptGuard::check);
  QueryComparisonConfig config = options.comparison;
  config.progress = [&](std::size_t done, std::size_t total) {
    advance(static_cast<double>(done) / static_cast<double>(total));
  };
  config.check = InterruptGuard::check;
  const std::size_t before = record.groups.size();
  compare_on_queries(registry, groups, config, record);
  if (!options.list) return;
  QueryRecord one = record;
  one.groups.erase(one.groups.begin(), one.groups.begin() + static_cast<std::ptrdiff_t>(before));
  print_lists(one, groups);
}

/// Processes all steps and returns the exit code. Complete groups are kept.
int compare_on_steps(const QueriesOptions& options, const Registry& registry, QueryRecord& record) {
  const StepRange range = steps_of(options);
  Progress progress("testing queries", static_cast<std::size_t>(range.end - range.begin), "steps");
  try {
    for (int k = range.begin; k < range.end; ++k)
      compare_on_step(
          options, registry, k,
          [&](double share) { progress.advance(static_cast<std::size_t>(k - range.begin), share); }, record);
  } catch (const Interrupted&) {
    if (record.groups.empty())
      throw Interrupted("interrupted before the first group of queries was complete: no result");
    record.stopped_by = kStoppedByUser;
    return kInterrupted;
  } catch (const Error& error) {
    if (record.groups.empty()) throw;
    record.stopped_by = error.what();
    return kBadInput;
  }
  return kDone;
}

int run(const QueriesOptions& options, const Registry& registry) {
  const InterruptGuard guard;
  QueryRecord record;
  const int code = compare_on_steps(options, registry, record);
  record.file = options.sequence.file;
  const std::string incomplete =
      fmt::format("incomplete: {} group(s) of queries are complete; {}\n", record.groups.size(), record.stopped_by);
  const Report report(options.report);
  report.print("{}\n\n{}", record.file, query_table(record, report.width()));
  if (code != kDone) report.print("\n{}", incomplete);
  report.write("queries", record.to_json());
  if (code != kDone) {
    fmt::print(stderr, "volccd: {}", incomplete);
    return code;
  }
  const std::vector<std::string> broken = record.broken_promises();
  for (const std::string& line : broken) fmt::print(stderr, "volccd: {}\n", line);
  return broken.empty() ? kDone : kDifferent;
}

}  // namespace

void add_queries_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("queries", "narrow phases on elementary tests with known answers");
  const auto options = std::make_shared<QueriesOptions>();
  options->sequence.add_to(*command);
  command->get_option("FILE")->description("query file (HDF5), or a sequence or scene with ground truth");
  command
      ->add_option("--narrowphase", options->comparison.narrow_phases,
                   "name[:option=value...]; several are compared; default: that of VolCCD+")
      ->delimiter(',')
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--filters", options->comparison.filters,
                   "feature filters that run before each narrow phase; their time is included")
      ->delimiter(',')
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--set", options->comparison.settings, "stage.option=value; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command->add_flag("--candidates", options->source.candidates,
                    "for sequences: all pairs with overlapping swept boxes, not only those in the ground truth");
  command
      ->add_option("--judge", options->judge,
                   "narrow phase whose answers are used instead of the known answers in the file")
      ->type_name("NAME");
  command->add_option("--sample", options->source.sample, "at most N queries of each scene and kind; 0: all")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--rounds", options->comparison.rounds, "number of timed runs, whose median is printed; 0: no times")
      ->check(CLI::Range(0, 1000))
      ->type_name("N")
      ->capture_default_str();
  options->report.add_to(*command);
  command->add_flag("--list", options->list, "print every query that is missed or extra")->excludes("--json");
  command->footer(
      "Exit code 1 if a narrow phase whose guarantee is not `approximate` misses a query.\n"
      "Examples:\n"
      "  volccd queries ccd-queries.h5\n"
      "  volccd queries ccd-queries.h5 --narrowphase cubic,cubic:tolerance=1e-6 --list\n"
      "  volccd queries rod-twist.vtkhdf --candidates --filters feature-kdop,coplanarity --json\n"
      "  volccd queries run.vtkhdf --candidates --sample 100000 --judge exact --rounds 0");
  command->callback([options, &registry, &action] {
    action = [options, &registry] {
      options->sequence.file = sequence_file(options->sequence.file);
      return run(*options, registry);
    };
  });
}

}  // namespace volccd
