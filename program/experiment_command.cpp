#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/core/output_file.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/comparison.hpp>
#include <volccd/experiments/tables/feature_sets.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct ExperimentOptions {
  std::vector<std::string> names, pipelines;
  std::string output = "results";
  bool quick = false, full = false;
  unsigned threads = 1;
};

/// The real LS-DYNA run where the shared data is there; else the built-in sequence, written to `folder`, and says so.
std::string projectile_sequence(const std::filesystem::path& folder) {
  const std::string real = shared_data_path("ls-dyna-projectile.vtkhdf");
  if (std::filesystem::exists(real)) return real;
  const std::filesystem::path standin = folder / "builtin.vtkhdf";
  fmt::print("{} is not there (VOLCCD_DATA names another folder): taking the built-in sequence instead\n\n", real);
  write_scene(*make_scene("builtin", {}), standin.string());
  return standin.string();
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder, "", "is the folder for records and cannot be made: " + error.message());
}

std::string record_file(const ExperimentOptions& options, const std::string& name, const char* suffix) {
  return (std::filesystem::path(options.output) / (name + suffix)).string();
}

/// Before anything is measured.
void check_outputs(const ExperimentOptions& options, const std::string& name, const std::string& input = {}) {
  OutputPlan plan;
  plan.input("the sequence", input);
  for (const char* suffix : {".json", ".txt", ".incomplete.json", ".incomplete.txt"})
    plan.output("-o", record_file(options, name, suffix));
  plan.check();
}

/// Prints the tables and writes them and the record: an incomplete one never in the place of a whole one of another
/// run.
void keep(const ExperimentOptions& options, const std::string& name, const nlohmann::json& record,
          const std::string& tables, bool complete) {
  const std::string file = record_file(options, name, complete ? ".json" : ".incomplete.json");
  fmt::print("{}\n", tables);  // first: a disk that is full does not take them
  write_text_file(file, record.dump(complete && record.is_array() ? 1 : 2) + "\n");
  write_text_file(record_file(options, name, complete ? ".txt" : ".incomplete.txt"), tables);
  fmt::print("record: {}\n", file);
}

int run_projectile(const ExperimentOptions& options, const Registry& registry) {
  const InterruptGuard guard;
  make_folder(options.output);
  const std::string file = projectile_sequence(options.output);
  check_outputs(options, "projectile", file);
  SequenceReader reader(file);
  SequenceStepper stepper(reader);
  ComparisonConfig config;
  config.sequence = reader.file();
  config.rounds = options.full ? 5 : 1;
  config.pipelines.insert(config.pipelines.end(), options.pipelines.begin(), options.pipelines.end());
  const auto executor = make_interruptible_executor(options.threads);
  ComparisonRecord record;
  keep_complete_steps(record.compared, [&] {
    std::unique_ptr<Progress> progress;
    config.progress = [&](std::size_t done, std::size_t total) {
      if (!progress) progress = std::make_unique<Progress>("comparing pipelines, run", total);
      progress->advance(done);
      InterruptGuard::check();
    };
    compare_pipelines(registry, stepper, config, *executor, record);
  });
  const bool complete = record.compared.complete();
  const std::string tables = fmt::format(
      "{}\n{} motions, {} round(s) interleaved, {} thread(s); time: median over motions; counts: sum of all "
      "motions\n{}\n"
      "{}\n{}",
      reader.metadata().title.empty() ? reader.file() : reader.metadata().title, record.compared.done, record.rounds,
      record.threads, complete ? "" : "incomplete: " + record.compared.text() + "\n", comparison_table(record),
      share_table(record));
  keep(options, "projectile", record.to_json(), tables, complete);
  if (!complete) {
    fmt::print(stderr, "volccd: incomplete: {}\n", record.compared.text());
    return exit_code(record.compared);
  }
  for (const PipelineRecord& pipeline : record.pipelines)
    if (!pipeline.same_contacts) {
      fmt::print(stderr, "volccd: {} found other contacts than {}\n", pipeline.name, record.pipelines.front().name);
      return kDifferent;
    }
  return kDone;
}

struct Baked {
  std::string file, record;
};

/// Unless it is in the cache.
Baked bake_for(const ExperimentOptions& options, const SimulatedScene& scene, Executor& executor) {
  BakeSettings settings;
  settings.elements = options.quick ? scene.quick_elements : 0;
  BakeProgress progress(scene.name);
  const std::optional<std::string> file = bake(scene, settings, executor, progress.hooks());
  if (!file) throw Interrupted(scene.name + ": stopped; the same command goes on from the last whole frame");
  return {*file, bake_record_file(scene, settings)};
}

/// A record for each scene that is `wanted`. Those that are complete are kept when one fails or is interrupted.
int run_on_scenes(const ExperimentOptions& options, const std::string& name, bool (*wanted)(const SimulatedScene&),
                  RecordOfScene measure, std::string (*table)(const std::vector<nlohmann::json>&)) {
  const InterruptGuard guard;
  make_folder(options.output);
  check_outputs(options, name);
  const auto executor = make_executor(options.threads);
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
      if (!wanted(scene)) continue;
      const Baked baked = bake_for(options, scene, *executor);
      records.push_back(record_with_progress(scene.name, baked.file, baked.record, options.threads, measure));
    }
  } catch (const Interrupted& error) {
    stop(error, kInterrupted);
  } catch (const Error& error) {
    stop(error, kBadInput);
  }
  if (code == kDone) {
    keep(options, name, records, table(records), true);
    return kDone;
  }
  const std::string text = fmt::format("{} scene(s) are complete; {}", records.size(), stopped_by);
  keep(options, name, {{"complete", false}, {"stopped_by", stopped_by}, {"records", records}},
       fmt::format("incomplete: {}\n\n{}", text, table(records)), false);
  fmt::print(stderr, "volccd: incomplete: {}\n", text);
  return code;
}

int run_scenes(const ExperimentOptions& options, const Registry&) {
  return run_on_scenes(
      options, "scenes", [](const SimulatedScene& scene) { return scene.variant_of.empty(); }, scene_record,
      scene_table);
}

int run_feature_sets(const ExperimentOptions& options, const Registry&) {
  return run_on_scenes(
      options, "feature_sets",
      [](const SimulatedScene& scene) { return scene.name == "bullet" || scene.variant_of == "bullet"; },
      feature_set_record, feature_set_table);
}

struct Experiment {
  const char *name, *description;
  int (*run)(const ExperimentOptions& options, const Registry& registry);
};

constexpr Experiment kExperiments[] = {
    {"projectile", "NavCCD, HashCCD, VolCCD and VolCCD+ on a real penetration run: time, counts, shares",
     run_projectile},
    {"scenes", "the simulated scenes: sizes, motion, contacts, edits, energy (--quick: the small sizes)", run_scenes},
    {"feature-sets", "Figure 3: the bullet with contacts among all features, the boundary's, and the first surface's",
     run_feature_sets}};

int run(const ExperimentOptions& options, const Registry& registry) {
  std::vector<const Experiment*> chosen;
  for (const std::string& name : options.names) {
    std::string known;
    const std::size_t before = chosen.size();
    for (const Experiment& experiment : kExperiments) {
      known += (known.empty() ? "" : ", ") + std::string(experiment.name);
      if (name == experiment.name) chosen.push_back(&experiment);
    }
    if (chosen.size() == before) throw ConfigError(fmt::format("no experiment '{}'; there are {}", name, known));
  }
  int code = kDone;
  for (const Experiment* experiment : chosen)
    if (code == kDone) code = experiment->run(options, registry);
  return code;
}

}  // namespace

void add_experiment_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("experiment", "measurements that give the tables");
  command->require_subcommand(1);
  CLI::App* list = command->add_subcommand("list", "what there is");
  list->callback([&action] {
    action = [] {
      for (const Experiment& experiment : kExperiments)
        fmt::print("{:<12} {}\n", experiment.name, experiment.description);
      return kDone;
    };
  });
  CLI::App* run_command = command->add_subcommand("run", "measure, print the tables, keep the records");
  const auto options = std::make_shared<ExperimentOptions>();
  run_command->add_option("NAME", options->names, "see `volccd experiment list`")->required()->type_name("");
  run_command
      ->add_option("--pipelines", options->pipelines,
                   "projectile: pipelines to compare beside the four, NAME[,NAME...]")
      ->delimiter(',')
      ->allow_extra_args(false);
  run_command->add_option("-o,--output", options->output, "folder for tables and records")->capture_default_str();
  run_command->add_flag("--quick", options->quick, "projectile: one round (the default); others: the small sizes");
  run_command->add_flag("--full", options->full, "five rounds")->excludes("--quick");
  add_threads_option(*run_command, options->threads);
  run_command->footer(
      "Ctrl-C or an error keeps what was complete as NAME.incomplete.json and .txt; a whole record stays as it was.\n"
      "Examples:\n"
      "  volccd experiment run projectile --quick -o results/\n"
      "  volccd experiment run projectile --pipelines BruteForce -o results/\n"
      "  volccd experiment run scenes --threads 2 -o results/\n"
      "  volccd experiment run feature-sets --quick --threads 2 -o results/");
  run_command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
