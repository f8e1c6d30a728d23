#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/experiments/program/commands.hpp>
#include <volccd/experiments/program/progress.hpp>
#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/tables/comparison.hpp>

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
  const std::string tables =
      fmt::format("{}\n{} motions, {} round(s) interleaved, {} thread(s); time: median over motions; counts: sum of all motions\n\n"
                  "{}\n{}",
                  reader.metadata().title.empty() ? reader.file() : reader.metadata().title, stepper.motion_count(),
                  record.rounds, record.threads, comparison_table(record), share_table(record));
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

int run(const ExperimentOptions& options, const Registry& registry) {
  for (const std::string& name : options.names)
    if (name != "projectile") throw ConfigError(fmt::format("no experiment '{}'; there is projectile", name));
  int code = kDone;
  for (std::size_t i = 0; i < options.names.size() && code == kDone; ++i) code = run_projectile(options, registry);
  return code;
}

}  // namespace

void add_experiment_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("experiment", "measurements that give the tables");
  command->require_subcommand(1);
  CLI::App* list = command->add_subcommand("list", "what there is");
  list->callback([&action] {
    action = [] {
      fmt::print("projectile   NavCCD, HashCCD, VolCCD and VolCCD+ on a real penetration run: time, counts, shares\n");
      return kDone;
    };
  });
  CLI::App* run_command = command->add_subcommand("run", "measure, print the tables, keep the records");
  const auto options = std::make_shared<ExperimentOptions>();
  run_command->add_option("NAME", options->names, "see `volccd experiment list`")->required()->type_name("");
  run_command->add_option("-o,--output", options->output, "folder for tables and records")->capture_default_str();
  run_command->add_flag("--quick", options->quick, "one round (the default)");
  run_command->add_flag("--full", options->full, "five rounds")->excludes("--quick");
  run_command->add_option("--threads", options->threads, "0: as many as the machine has")->capture_default_str();
  run_command->footer("Example:\n  volccd experiment run projectile --quick -o results/");
  run_command->callback([options, &registry, &action] {
    action = [options, &registry] { return run(*options, registry); };
  });
}

}  // namespace volccd
