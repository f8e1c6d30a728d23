#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/harness/run.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/experiment_outputs.hpp>
#include <volccd/program/experiment_scenes.hpp>
#include <volccd/program/own_process.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

/// The sequence of a scene for a table: a sequence of another program, or a generated motion of a mesh, if the file is
/// present; or a simulated or built-in scene from the cache, which is generated first if it is missing.
std::optional<std::string> scene_file(const ExperimentOptions& options, const std::string& name) {
  const Report report(options.report);
  if (is_deformed_scene(name)) {
    const std::optional<std::string> file = deformed_scene_file(name);
    if (!file)
      report.print("the mesh of {} is not there: it is left out of the tables\n(VOLCCD_DATA names its folder)\n", name);
    return file;
  }
  constexpr const char* kShared[] = {"ls-dyna-projectile", "octopus2-105k", "cloth-ball", "rod-twist"};
  const bool external = name.starts_with("openradioss-") ||
                        std::any_of(std::begin(kShared), std::end(kShared), [&](const char* o) { return name == o; });
  const std::string file = external ? shared_data_path(name + ".vtkhdf") : "";
  if (external && !std::filesystem::exists(file)) {
    report.print("{} is not there: it is left out of the tables\n(VOLCCD_DATA names another folder)\n", file);
    return std::nullopt;
  }
  if (name == "builtin") report.print("taking the built-in sequence\n");
  return external ? file : sequence_file(name, options.simulation_threads());
}

/// Returns exit code 1, with a message on stderr, if pipelines that must find the same contacts found different ones.
int same_contacts(const ExperimentKind& kind, const Registry& registry, const ExperimentPlan& plan,
                  const std::vector<nlohmann::json>& rows) {
  if (kind.rows) return kDone;
  const std::vector<std::string> lines = contact_differences(registry, plan, rows);
  for (const std::string& line : lines) fmt::print(stderr, "volccd: {}: other contacts: {}\n", kind.name, line);
  return lines.empty() ? kDone : kDifferent;
}

/// Opens the record, and says what an earlier, interrupted run left in it.
RecordFile open_record(const ExperimentOptions& options, const std::string& name, const nlohmann::json& identity) {
  const Report report(options.report);
  RecordFile record(options.output, name, identity);
  if (record.set_aside())
    report.print("{}: rows of another build or plan, kept as {}\n", record.incomplete_file(), record.old_file());
  if (record.resumed() > 0)
    report.print("{}: continued; {} complete\n", record.incomplete_file(), counted(record.resumed(), "part"));
  return record;
}

/// Runs the measurements that are missing in the record, with a line of progress. Returns false if some are left for
/// another process.
bool measure(const ExperimentKind& kind, const PlanContext& context, const ExperimentPlan& plan, RecordFile& record) {
  try {
    if (kind.rows) {
      PlanContext of_rows = context;
      std::unique_ptr<Progress> progress;
      of_rows.progress = [&](std::size_t done, std::size_t total) {
        if (!progress) progress = std::make_unique<Progress>(kind.name, total, "scenes");
        progress->advance(done);
        InterruptGuard::check();
      };
      kind.rows(of_rows, record);
      return true;
    }
    Progress progress(kind.name, measured_runs(plan), "runs");
    return run_experiment(context.registry, plan, *context.executor, record, [&](std::size_t done, std::size_t) {
      progress.advance(done);
      InterruptGuard::check();
    });
  } catch (const Interrupted&) {
    throw Interrupted(
        fmt::format("{}: stopped; the same command continues the run from {}", kind.name, record.incomplete_file()));
  }
}

/// Writes the record and its tables, and prints the tables.
void write_results(const ExperimentKind& kind, const ExperimentOptions& options, nlohmann::json facts,
                   RecordFile& record, Finished& finished) {
  const Report report(options.report);
  facts["load_at_end"] = machine_facts().at("load");
  const nlohmann::json whole = {{"rows", record.rows()}, {"provenance", facts}};
  record.finish(facts, kind.summary ? kind.summary(whole) : nlohmann::json::array());
  const std::vector<TitledTable> made = kind.tables(whole);
  const std::string tables = render(made, TableFormat::text);
  report.print("{}\n", render(made, TableFormat::text, report.width()));
  write_text_file(record_file(options, kind.name, ".txt"), tables);
  report.print("record: {}\n", record.file());
  add_finished(kind.name, record.file(), true, tables, finished);
}

/// Lets another process measure the rounds that are left, and write the results.
int continue_in_another_process(const ExperimentKind& kind, const ExperimentOptions& options, const std::string& file,
                                Finished& finished) {
  Report(options.report).print("{}: the other rounds follow in another process\n", kind.name);
  const int code = run_own_process(options.arguments_of(kind.name));
  if (code == kDone || code == kDifferent)
    add_finished(kind.name, file, true, render(kind.tables(read_record(file)), TableFormat::text), finished);
  return code;
}

/// Runs the measurements that are missing in the record of an earlier, interrupted run, and writes record and tables.
int run_kind(const ExperimentKind& kind, const ExperimentOptions& options, const Registry& registry,
             Finished& finished) {
  const InterruptGuard guard;
  make_folder(options.output);
  const auto executor = make_interruptible_executor(options.timed_threads());
  std::map<std::string, std::optional<std::string>> files;  // asked for by the plan, and again by what makes the rows
  const auto file_of = [&](const std::string& name) {
    if (!files.contains(name)) files[name] = scene_file(options, name);
    return files.at(name);
  };
  PlanContext context{registry, options.full, options.pipelines, options.settings, file_of, executor.get()};
  context.own_scenes = options.own_scenes();
  ExperimentPlan plan = kind.plan(context);
  options.change_plan(plan);
  if (plan.runs.empty()) throw ConfigError(fmt::format("{}: none of its scenes is there", kind.name));
  check_outputs(options, kind.name, plan);
  const nlohmann::json facts = provenance(plan, *executor), identity = identity_of(facts);
  const std::string file = record_file(options, kind.name, ".json");
  if (const auto whole = options.skip_complete ? complete_record(file, identity) : std::nullopt) {
    Report(options.report).print("{}: is complete, of the same program, plan and inputs; it is kept\n", file);
    add_finished(kind.name, file, true, render(kind.tables(*whole), TableFormat::text), finished);
    return same_contacts(kind, registry, plan, whole->at("rows"));
  }
  {
    RecordFile record = open_record(options, kind.name, identity);
    if (measure(kind, context, plan, record)) {
      write_results(kind, options, facts, record, finished);
      return same_contacts(kind, registry, plan, record.rows());
    }
  }
  return continue_in_another_process(kind, options, file, finished);
}

int run_one(const std::string& name, const ExperimentOptions& options, const Registry& registry, Finished& finished) {
  if (const ExperimentKind* kind = find_kind(name)) return run_kind(*kind, options, registry, finished);
  return run_scenes(options, finished);
}

int run(const ExperimentOptions& options, const Registry& registry) {
  const std::vector<std::pair<std::string, ExperimentOptions>> jobs = experiment_jobs(options);
  for (const auto& [name, own] : jobs) protect_other_record(own, name);
  Finished finished;
  int code = kDone;  // if contacts differ in one experiment, the next one still runs
  for (const auto& [name, own] : jobs) {
    const int one = run_one(name, own, registry, finished);
    if (one != kDone) code = one;
    if (one != kDone && one != kDifferent) break;
  }
  Report(options.report).write("experiment run", {{"experiments", finished}});
  return code;
}

constexpr const char* kRunFooter =
    "If all steps would take too long, an evenly spaced sample is taken, which the record lists. After Ctrl-C or "
    "an error, the same command continues with the rows in NAME.incomplete.jsonl (scenes: scenes.incomplete.json and "
    ".txt have the complete scenes); an earlier record is unchanged until then.\n"
    "Exit code 1 if pipelines that must find the same contacts found different ones.\n"
    "Examples:\n"
    "  volccd experiment run projectile --quick\n"
    "  volccd experiment run projectile --pipelines BruteForce -o build/brute-force\n"
    "  volccd experiment run ablation --pipelines VolCCD,VolCCD+ --set csat.axis=face,centroid\n"
    "  volccd experiment run table1 ablation plus --scenes my.vtkhdf,other.vtkhdf --steps 10:20 --rounds 5 -o mine\n"
    "  volccd experiment run all --full --skip-complete -o results/";

}  // namespace

void add_experiment_run_command(CLI::App& experiment, const Registry& registry, Action& action) {
  CLI::App* run_command =
      experiment.add_subcommand("run", "runs measurements, prints their tables, and stores the records");
  const auto options = std::make_shared<ExperimentOptions>();
  options->add_to(*run_command);
  run_command->footer(kRunFooter);
  run_command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
