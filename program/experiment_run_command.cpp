#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/harness/run.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/experiment_names.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/own_process.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct ExperimentOptions {
  std::vector<std::string> names, pipelines, settings, scenes;
  std::string output = kDefaultResults, steps;
  int rounds = 0;  ///< 0: those of the experiment
  bool quick = false, full = false, skip_complete = false;
  std::optional<unsigned> threads;
  ReportOptions report;

  /// Default: one thread for timed experiments, as in the paper; all threads for simulations.
  unsigned timed_threads() const { return threads.value_or(1); }
  unsigned simulation_threads() const { return threads.value_or(0); }
};

/// The results of one experiment, for --json.
using Finished = std::vector<nlohmann::json>;

void add_finished(const std::string& name, const std::string& record, bool complete, const std::string& text,
                  Finished& finished) {
  finished.push_back({{"experiment", name}, {"record", record}, {"complete", complete}, {"text", text}});
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder, "", "cannot be created as the folder for records: " + error.message());
}

std::string record_file(const ExperimentOptions& options, const std::string& name, const char* suffix) {
  return (std::filesystem::path(options.output) / (name + suffix)).string();
}

/// Called before anything is measured.
void check_outputs(const ExperimentOptions& options, const std::string& name, const ExperimentPlan& experiment = {}) {
  OutputPlan plan;
  for (const SceneRun& run : experiment.runs) plan.input("the sequence", run.file);
  for (const char* suffix :
       {".json", ".txt", ".incomplete.json", ".incomplete.txt", ".incomplete.jsonl", ".incomplete.old.jsonl"})
    plan.output("-o", record_file(options, name, suffix));
  plan.check();
}

/// Whether the file is a record of a run with --full. A file that cannot be read is none.
bool is_full_record(const std::string& file) {
  const nlohmann::json record = nlohmann::json::parse(std::ifstream(file), nullptr, false);
  if (record.is_object()) return record.value("/provenance/setting"_json_pointer, "") == "full";
  if (!record.is_array()) return false;
  return std::any_of(record.begin(), record.end(), [](const nlohmann::json& scene) {  // of `scenes`
    if (!scene.is_object()) return false;
    const SimulatedScene* known = find_simulated_scene(scene.value("scene", ""));
    return known && scene.value("/simulation/elements"_json_pointer, 0) > known->quick_elements;
  });
}

bool is_record_of_own_scenes(const nlohmann::json& record) {
  return record.is_object() && record.value("/provenance/options"_json_pointer, "").find("--scenes") == 0;
}

/// Hours of measurements are not replaced by minutes, nor measurements of the experiment's scenes by those of others,
/// nor these by those. Called before anything is measured.
void keep_other_record(const ExperimentOptions& options, const std::string& name) {
  const bool full = name == kScenesExperiment ? !options.quick : options.full;
  const std::string file = record_file(options, name, ".json");
  if (std::filesystem::exists(file) &&
      is_record_of_own_scenes(nlohmann::json::parse(std::ifstream(file), nullptr, false)) == options.scenes.empty())
    throw ConfigError(fmt::format("-o {}: {} is the record of {}; give another folder, or remove the file",
                                  options.output, file,
                                  options.scenes.empty() ? "a run with --scenes" : "the experiment's own scenes"));
  if (full || !is_full_record(file)) return;
  throw ConfigError(
      fmt::format("-o {}: {} is the record of a full run, which a quick run does not replace; give another "
                  "folder, or remove the file",
                  options.output, file));
}

/// Prints the tables, and writes them and the record. An incomplete record never replaces a complete one of another
/// run.
void keep(const ExperimentOptions& options, const std::string& name, const nlohmann::json& record,
          const std::string& tables, bool complete, Finished& finished) {
  const Report report(options.report);
  const std::string file = record_file(options, name, complete ? ".json" : ".incomplete.json");
  report.print("{}\n", tables);  // first, so that they are seen even if the disk is full
  write_text_file(file, record.dump(complete && record.is_array() ? 1 : 2) + "\n");
  write_text_file(record_file(options, name, complete ? ".txt" : ".incomplete.txt"), tables);
  report.print("record: {}\n", file);
  add_finished(name, file, complete, tables, finished);
}

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

std::vector<std::string> kinds_that_take_scenes() {
  std::vector<std::string> names;
  for (const ExperimentKind& kind : experiment_kinds())
    if (kind.takes_scenes) names.emplace_back(kind.name);
  return names;
}

/// Options that the experiment would ignore are refused.
void check_options(const ExperimentKind* kind, const std::string& name, const ExperimentOptions& options) {
  if (!options.pipelines.empty() && !(kind && kind->takes_pipelines))
    throw ConfigError(fmt::format("{} takes no --pipelines: its pipelines are fixed", name));
  if (!options.settings.empty() && !(kind && kind->takes_settings))
    throw ConfigError(fmt::format("{} takes no --set; `volccd experiment run ablation --set ...` does", name));
  if (!options.scenes.empty() && !(kind && kind->takes_scenes))
    throw ConfigError(fmt::format("{} takes no --scenes: its scenes are fixed; {} do", name,
                                  fmt::join(kinds_that_take_scenes(), ", ")));
  if ((!options.steps.empty() || options.rounds > 0) && (!kind || kind->rows))
    throw ConfigError(fmt::format("{} takes no {}", name, options.steps.empty() ? "--rounds" : "--steps"));
}

/// Sequences of the caller, by the names of their files; by their whole paths if two files have one name.
std::vector<TableScene> own_scenes(const ExperimentOptions& options) {
  std::vector<TableScene> scenes;
  std::map<std::string, int> count;
  const auto name_of_file = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
  for (const std::string& scene : options.scenes) ++count[name_of_file(scene)];
  for (const std::string& scene : options.scenes) {
    const std::string name = name_of_file(scene);
    const auto same = [&](const TableScene& other) { return other.name == name || other.name == scene; };
    if (std::any_of(scenes.begin(), scenes.end(), same))
      throw ConfigError(fmt::format("--scenes: {} is there twice", scene));
    scenes.push_back({count[name] > 1 ? scene : name, sequence_file(scene, options.simulation_threads())});
  }
  return scenes;
}

/// Makes --steps and --rounds those of all runs. The record has names of files without their folders.
void change_plan(const ExperimentOptions& options, ExperimentPlan& plan) {
  std::vector<std::string> files;
  for (const std::string& scene : options.scenes) files.push_back(std::filesystem::path(scene).filename().string());
  if (!files.empty()) plan.options += fmt::format("--scenes {} ", fmt::join(files, ","));
  if (!options.steps.empty()) plan.options += fmt::format("--steps {} ", options.steps);
  if (options.rounds > 0) plan.options += fmt::format("--rounds {} ", options.rounds);
  if (!plan.options.empty()) plan.options.pop_back();
  if (options.rounds > 0) {
    plan.rounds = options.rounds;
    plan.processes = std::min(plan.processes, plan.rounds);
  }
  for (SceneRun& run : plan.runs) {
    if (options.rounds > 0) run.rounds = 0;
    if (options.steps.empty()) continue;
    const StepRange range = parse_steps(options.steps, step_count(run.file), run.file);
    run.windows = {{range.begin, range.end - range.begin}};
  }
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

/// The arguments with which this program runs the experiment as it does here.
std::vector<std::string> arguments_of(const ExperimentOptions& options, const std::string& name) {
  std::vector<std::string> words = {"experiment", "run", name, "--output=" + options.output,
                                    options.full ? "--full" : "--quick"};
  if (!options.pipelines.empty()) words.push_back(fmt::format("--pipelines={}", fmt::join(options.pipelines, ",")));
  if (!options.scenes.empty()) words.push_back(fmt::format("--scenes={}", fmt::join(options.scenes, ",")));
  for (const std::string& setting : options.settings) words.push_back("--set=" + setting);
  if (!options.steps.empty()) words.push_back("--steps=" + options.steps);
  if (options.rounds > 0) words.push_back(fmt::format("--rounds={}", options.rounds));
  if (options.threads) words.push_back(fmt::format("--threads={}", *options.threads));
  if (options.report.quiet || options.report.json) words.emplace_back("--quiet");
  return words;
}

/// Lets another process measure the rounds that are left, and write the results.
int continue_in_another_process(const ExperimentKind& kind, const ExperimentOptions& options, const std::string& file,
                                Finished& finished) {
  Report(options.report).print("{}: the other rounds follow in another process\n", kind.name);
  const int code = run_own_process(arguments_of(options, kind.name));
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
  context.own_scenes = own_scenes(options);
  ExperimentPlan plan = kind.plan(context);
  change_plan(options, plan);
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

struct Baked {
  std::string file, record;
};

/// Bakes the scene unless it is in the cache.
Baked bake_for(const ExperimentOptions& options, const SimulatedScene& scene, Executor& executor) {
  BakeSettings settings;
  settings.elements = options.quick ? scene.quick_elements : 0;
  BakeProgress progress(scene.name);
  const std::optional<std::string> file = bake(scene, settings, executor, progress.hooks());
  if (!file) throw Interrupted(scene.name + ": stopped; the same command goes on from the last whole frame");
  return {*file, bake_record_file(scene, settings)};
}

/// Makes a record for each simulated scene that is no variant of another. Complete records are kept if a scene fails or
/// is interrupted.
int run_scenes(const ExperimentOptions& options, Finished& finished) {
  const std::string name = kScenesExperiment;
  const InterruptGuard guard;
  make_folder(options.output);
  check_outputs(options, name);
  const auto executor = make_executor(options.simulation_threads());
  std::vector<nlohmann::json> records;
  std::string stopped_by;
  int code = kDone;
  const auto stop = [&](const Error& error, int exit) {
    if (records.empty()) throw;
    stopped_by = error.what();
    code = exit;
  };
  try {
    for (const SimulatedScene& scene : simulated_scenes()) {
      if (!scene.variant_of.empty()) continue;
      const Baked baked = bake_for(options, scene, *executor);
      records.push_back(
          record_with_progress(scene.name, baked.file, baked.record, options.simulation_threads(), scene_record));
    }
  } catch (const Interrupted& error) {
    stop(error, kInterrupted);
  } catch (const Error& error) {
    stop(error, kBadInput);
  }
  if (code == kDone) {
    keep(options, name, records, untitled_text(scene_table(records)), true, finished);
    return kDone;
  }
  const std::string text = fmt::format("{} complete; {}", counted(records.size(), "scene"), stopped_by);
  keep(options, name, {{"complete", false}, {"stopped_by", stopped_by}, {"records", records}},
       fmt::format("incomplete: {}\n\n{}", text, untitled_text(scene_table(records))), false, finished);
  fmt::print(stderr, "volccd: incomplete: {}\n", text);
  return code;
}

int run_one(const std::string& name, const ExperimentOptions& options, const Registry& registry, Finished& finished) {
  if (const ExperimentKind* kind = find_kind(name)) return run_kind(*kind, options, registry, finished);
  return run_scenes(options, finished);
}

/// Runs all experiments. Additional pipelines and settings are given to the experiments that support them. The scenes
/// are small unless --full is given.
std::vector<std::pair<std::string, ExperimentOptions>> all_experiments(ExperimentOptions options) {
  options.quick = !options.full;
  std::vector<std::pair<std::string, ExperimentOptions>> jobs;
  for (const ExperimentKind& kind : experiment_kinds()) {
    jobs.emplace_back(kind.name, options);
    if (!kind.takes_pipelines) jobs.back().second.pipelines.clear();
    if (!kind.takes_settings) jobs.back().second.settings.clear();
  }
  jobs.emplace_back(kScenesExperiment, options);
  return jobs;
}

int run(const ExperimentOptions& options, const Registry& registry) {
  std::vector<std::pair<std::string, ExperimentOptions>> jobs;
  for (const std::string& name : options.names) {  // before the first experiment takes its time
    if (name == "all") {
      if (!options.scenes.empty() || !options.steps.empty() || options.rounds > 0)
        throw ConfigError("all takes no --scenes, --steps or --rounds: name the experiments");
      const auto all = all_experiments(options);
      jobs.insert(jobs.end(), all.begin(), all.end());
      continue;
    }
    if (!find_kind(name) && name != kScenesExperiment) unknown_experiment("experiment", name);
    check_options(find_kind(name), name, options);
    jobs.emplace_back(name, options);
  }
  for (const auto& [name, own] : jobs) keep_other_record(own, name);
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
  run_command->add_option("NAME", options->names, "see `volccd experiment list`")->required()->type_name("");
  run_command
      ->add_option("--pipelines", options->pipelines, "additional pipelines, NAME[,NAME...]; ablation runs only these")
      ->delimiter(',')
      ->allow_extra_args(false);
  run_command
      ->add_option("--set", options->settings,
                   "for ablation: stage.option=value[,value...], with a run for each value, or role=stage[,stage...]; "
                   "may be repeated")
      ->type_name("SETTING")
      ->allow_extra_args(false);
  run_command
      ->add_option("--scenes", options->scenes,
                   "sequences (VTKHDF) or names of scenes in the place of the experiment's, FILE[,FILE...]: for " +
                       fmt::format("{}", fmt::join(kinds_that_take_scenes(), ", ")))
      ->delimiter(',')
      ->type_name("FILES")
      ->allow_extra_args(false);
  run_command
      ->add_option("--steps", options->steps,
                   "measures all steps k with A <= k < B of each scene (K: one step) in the place of a sample")
      ->type_name("A:B");
  run_command->add_option("--rounds", options->rounds, "how often each step is measured; tables show medians")
      ->check(at_least(1))
      ->type_name("N");
  run_command
      ->add_option("-o,--output", options->output,
                   "folder for tables and records; a quick run does not replace the record of a full one")
      ->capture_default_str();
  run_command->add_flag("--quick", options->quick,
                        "takes minutes: small scenes, few steps, one round (the default of experiments with rounds)");
  run_command
      ->add_flag("--full", options->full, "takes hours: scenes at their default sizes, more steps, several rounds")
      ->excludes("--quick");
  run_command->add_flag("--skip-complete", options->skip_complete,
                        "keeps the records that are complete and of the same program, machine, plan and inputs, so "
                        "that an interrupted `all` goes on where it was (scenes are always made again)");
  run_command
      ->add_option("--threads", options->threads,
                   "number of threads; 0: as many as the machine has; default: 1 for timed experiments, as in the "
                   "paper, and 0 for simulations")
      ->check(CLI::Range(0u, kMaxThreads))
      ->type_name("N");
  options->report.add_to(*run_command);
  run_command->footer(kRunFooter);
  run_command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
