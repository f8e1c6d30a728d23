#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/oracle/judge/stage_check.hpp>
#include <volccd/program/allocation_count.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

struct CheckOptions {
  std::string stage, file, steps;
  std::vector<std::string> settings;
  StageCheckConfig config;
  ReportOptions report;
  unsigned threads = 0;
};

/// "name=value" or "stage.name=value".
void set_option(const CheckOptions& options, const std::string& setting, OptionValues& values) {
  const std::size_t equals = setting.find('=');
  std::string name = setting.substr(0, equals);
  if (name.starts_with(options.stage + ".")) name.erase(0, options.stage.size() + 1);
  if (equals == std::string::npos || name.empty() || name.find('.') != std::string::npos)
    throw ConfigError(fmt::format("--set {}: not an option of the stage, {}.option=value", setting, options.stage));
  values[name] = setting.substr(equals + 1);
}

void print(const StageReport& report, const Report& out) {
  out.print("{} ({}), declared {}\n\n", report.stage, report.role, to_string(report.guarantee));
  TextTable table({"promise", "answers", "broken", ""});
  for (const PromiseReport& one : report.promises)
    table.add({one.promise, grouped(one.checked), grouped(one.broken),
               one.kept() ? (one.required ? "kept" : "not promised") : "BROKEN"});
  out.print("{}", table.text(out.width()));
  for (const PromiseReport& one : report.promises)
    if (!one.kept()) out.print("\n{}\n  {}\n", one.promise, one.example);
  out.print("\n{}\n", report.kept() ? "all promises kept" : "PROMISES BROKEN");
}

nlohmann::json to_json(const StageReport& report) {
  nlohmann::json promises = nlohmann::json::array();
  for (const PromiseReport& one : report.promises)
    promises.push_back({{"promise", one.promise},
                        {"required", one.required},
                        {"checked", one.checked},
                        {"broken", one.broken},
                        {"kept", one.kept()},
                        {"example", one.example}});
  return {{"stage", report.stage},
          {"role", report.role},
          {"guarantee", to_string(report.guarantee)},
          {"kept", report.kept()},
          {"promises", promises}};
}

/// At least two workers, because the check compares several workers with one.
unsigned workers(unsigned threads) { return std::max(2u, threads > 0 ? threads : make_executor(0)->workers()); }

int run(CheckOptions options, const Registry& registry) {
  for (const std::string& setting : options.settings) set_option(options, setting, options.config.options);
  if (!options.file.empty()) {
    const std::string file = sequence_file(options.file);
    const auto reader = std::make_shared<SequenceReader>(file);
    const StepRange range = parse_steps(options.steps, reader->frame_count() - 1, file);
    options.config.further_steps = [file, reader, range](const auto& use) {
      SequenceStepper stepper(*reader);
      const ObjectFilter everything;
      for (int k = range.begin; k < range.end; ++k) {
        stepper.go_to(k);
        use({stepper.topology(), stepper.motion(), everything}, fmt::format("{}, step {}", file, k));
      }
    };
  }
  options.config.allocation_count = allocation_count;
  options.config.threads = workers(options.threads);
  const InterruptGuard guard;
  std::optional<Progress> progress;
  options.config.progress = [&](int done, int total) {
    InterruptGuard::check();
    if (done == 0) progress.emplace("checking " + options.stage, static_cast<std::size_t>(total), "trials");
    progress->advance(static_cast<std::size_t>(done));
  };
  const StageReport report = check_stage(registry, options.stage, options.config);
  progress.reset();
  const Report out(options.report);
  print(report, out);
  out.write("check", to_json(report));
  return report.kept() ? kDone : kDifferent;
}

}  // namespace

void add_check_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("check", "checks whether one stage keeps its declared properties");
  const auto options = std::make_shared<CheckOptions>();
  command->add_option("STAGE", options->stage, "name of a stage, as `volccd stages` lists it")->required();
  command->add_option("FILE", options->file, "sequence, or name of a scene, whose steps are checked as well");
  command->add_option("--steps", options->steps, "steps of FILE: K, A:B, A:, :B (default all)");
  command->add_option("--set", options->settings, "an option of the stage: stage.option=value");
  command->add_option("--trials", options->config.trials, "generated trials")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  command->add_option("--seed", options->config.seed, "seed of the first trial; each further trial has the next seed")
      ->capture_default_str();
  command
      ->add_option("--threads", options->threads,
                   "workers of the checks with several workers; 0: as many as the machine has, but at least two")
      ->check(CLI::Range(0u, kMaxThreads))
      ->type_name("N")
      ->capture_default_str();
  options->report.add_to(*command);
  command->footer(
      "Runs the stage on generated tests and elements that touch or nearly touch, and compares it with exact "
      "arithmetic: alone and "
      "in batches, with several workers, with a new state and with one that has seen other steps. Then compares "
      "pipelines with and without it on small colliding bodies and on FILE; those with a flood or an orphan source "
      "also "
      "on generated meshes with irregular stars, pinned strips and nested bodies. What is not promised (approximate) "
      "is counted.\n"
      "Exit code 1 if a property does not hold; the printed options --seed N --trials 1 repeat the trial.\n"
      "Examples:\n"
      "  volccd check csat\n"
      "  volccd check csat run.vtkhdf --set csat.axis=optimal --trials 20000\n"
      "  volccd check coplanarity --seed 4711 --trials 1");
  command->callback(
      [options, &registry, &action] { action = [options, &registry] { return run(*options, registry); }; });
}

}  // namespace volccd
