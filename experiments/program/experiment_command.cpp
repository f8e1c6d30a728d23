#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/experiments/program/commands.hpp>
#include <volccd/experiments/program/progress.hpp>
#include <volccd/experiments/program/scene_files.hpp>
#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/comparison.hpp>
#include <volccd/experiments/tables/feature_sets.hpp>
#include <volccd/experiments/tables/scene_table.hpp>

namespace volccd {

namespace {

struct ExperimentOptions {
  std::vector<std::string> names;
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

int run_projectile(const ExperimentOptions& options, const Registry& registry) {
  std::filesystem::create_directories(options.output);
  SequenceReader reader(projectile_sequence(options.output));
  SequenceStepper stepper(reader);
  ComparisonConfig config;
  config.sequence = reader.file();
  config.rounds = options.full ? 5 : 1;
  config.threads = options.threads;
  const InterruptGuard guard;
  ComparisonRecord record;
  {
    std::unique_ptr<Progress> progress;
    config.progress = [&](std::size_t done, std::size_t total) {
      if (!progress) progress = std::make_unique<Progress>("comparing pipelines, run", total);
      progress->advance(done);
      return InterruptGuard::interrupted();
    };
    record = compare_pipelines(registry, stepper, config);
  }
  const std::string tables = fmt::format(
      "{}\n{} motions, {} round(s) interleaved, {} thread(s); time: median over motions; counts: sum of all motions\n\n"
      "{}\n{}",
      reader.metadata().title.empty() ? reader.file() : reader.metadata().title, stepper.motion_count(), record.rounds,
      record.threads, comparison_table(record), share_table(record));
  const std::filesystem::path folder = options.output;
  write_text_file((folder / "projectile.json").string(), record.to_json().dump(2) + "\n");
  write_text_file((folder / "projectile.txt").string(), tables);
  fmt::print("{}\nrecord: {}\n", tables, (folder / "projectile.json").string());
  if (InterruptGuard::interrupted()) return kInterrupted;
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

int keep(const ExperimentOptions& options, const std::string& name, const std::vector<nlohmann::json>& records,
         const std::string& table) {
  const std::filesystem::path folder = options.output;
  std::filesystem::create_directories(folder);
  write_text_file((folder / (name + ".json")).string(), nlohmann::json(records).dump(1) + "\n");
  write_text_file((folder / (name + ".txt")).string(), table);
  fmt::print("{}\nrecord: {}\n", table, (folder / (name + ".json")).string());
  return kDone;
}

int run_scenes(const ExperimentOptions& options, const Registry&) {
  const auto executor = make_executor(options.threads);
  std::vector<nlohmann::json> records;
  for (const SimulatedScene& scene : simulated_scenes()) {
    if (!scene.variant_of.empty()) continue;
    const Baked baked = bake_for(options, scene, *executor);
    records.push_back(record_with_progress(scene.name, baked.file, baked.record, *executor, scene_record));
  }
  return keep(options, "scenes", records, scene_table(records));
}

int run_feature_sets(const ExperimentOptions& options, const Registry&) {
  const auto executor = make_executor(options.threads);
  std::vector<nlohmann::json> records;
  for (const SimulatedScene& scene : simulated_scenes()) {
    if (scene.name != "bullet" && scene.variant_of != "bullet") continue;
    const Baked baked = bake_for(options, scene, *executor);
    records.push_back(record_with_progress(scene.name, baked.file, baked.record, *executor, feature_set_record));
  }
  return keep(options, "feature_sets", records, feature_set_table(records));
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
  run_command->add_option("-o,--output", options->output, "folder for tables and records")->capture_default_str();
  run_command->add_flag("--quick", options->quick, "projectile: one round (the default); others: the small sizes");
  run_command->add_flag("--full", options->full, "five rounds")->excludes("--quick");
  run_command->add_option("--threads", options->threads, "0: as many as the machine has")->capture_default_str();
  run_command->footer(
      "Examples:\n"
      "  volccd experiment run projectile --quick -o results/\n"
      "  volccd experiment run scenes --threads 2 -o results/\n"
      "  volccd experiment run feature-sets --quick --threads 2 -o results/");
  run_command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
