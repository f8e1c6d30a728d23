#include <volccd/program/experiment_options.hpp>

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include <volccd/experiments/harness/run.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

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

}  // namespace

void ExperimentOptions::add_to(CLI::App& command) {
  command.add_option("NAME", names, "see `volccd experiment list`")->required()->type_name("");
  command.add_option("--pipelines", pipelines, "additional pipelines, NAME[,NAME...]; ablation runs only these")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option("--set", settings,
                  "for ablation: stage.option=value[,value...], with a run for each value, or role=stage[,stage...]; "
                  "may be repeated")
      ->type_name("SETTING")
      ->allow_extra_args(false);
  command
      .add_option("--scenes", scenes,
                  "sequences (VTKHDF) or names of scenes in the place of the experiment's, FILE[,FILE...]: for " +
                      fmt::format("{}", fmt::join(kinds_that_take_scenes(), ", ")))
      ->delimiter(',')
      ->type_name("FILES")
      ->allow_extra_args(false);
  command
      .add_option("--steps", steps,
                  "measures all steps k with A <= k < B of each scene (K: one step) in the place of a sample")
      ->type_name("A:B");
  command.add_option("--rounds", rounds, "how often each step is measured; tables show medians")
      ->check(at_least(1))
      ->type_name("N");
  command
      .add_option("-o,--output", output,
                  "folder for tables and records; a quick run does not replace the record of a full one")
      ->capture_default_str();
  command.add_flag("--quick", quick,
                   "takes minutes: small scenes, few steps, one round (the default of experiments with rounds)");
  command.add_flag("--full", full, "takes hours: scenes at their default sizes, more steps, several rounds")
      ->excludes("--quick");
  command.add_flag("--skip-complete", skip_complete,
                   "keeps the records that are complete and of the same program, machine, plan and inputs, so "
                   "that an interrupted `all` goes on where it was (scenes are always made again)");
  command
      .add_option("--threads", threads,
                  "number of threads; 0: as many as the machine has; default: 1 for timed experiments, as in the "
                  "paper, and 0 for simulations")
      ->check(CLI::Range(0u, kMaxThreads))
      ->type_name("N");
  report.add_to(command);
}

std::vector<TableScene> ExperimentOptions::own_scenes() const {
  std::vector<TableScene> own;
  std::map<std::string, int> count;
  const auto name_of_file = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
  for (const std::string& scene : scenes) ++count[name_of_file(scene)];
  for (const std::string& scene : scenes) {
    const std::string name = name_of_file(scene);
    const auto same = [&](const TableScene& other) { return other.name == name || other.name == scene; };
    if (std::any_of(own.begin(), own.end(), same)) throw ConfigError(fmt::format("--scenes: {} is there twice", scene));
    own.push_back({count[name] > 1 ? scene : name, sequence_file(scene, simulation_threads())});
  }
  return own;
}

void ExperimentOptions::change_plan(ExperimentPlan& plan) const {
  std::vector<std::string> files;
  for (const std::string& scene : scenes) files.push_back(std::filesystem::path(scene).filename().string());
  if (!files.empty()) plan.options += fmt::format("--scenes {} ", fmt::join(files, ","));
  if (!steps.empty()) plan.options += fmt::format("--steps {} ", steps);
  if (rounds > 0) plan.options += fmt::format("--rounds {} ", rounds);
  if (!plan.options.empty()) plan.options.pop_back();
  if (rounds > 0) {
    plan.rounds = rounds;
    plan.processes = std::min(plan.processes, plan.rounds);
  }
  for (SceneRun& run : plan.runs) {
    if (rounds > 0) run.rounds = 0;
    if (steps.empty()) continue;
    const StepRange range = parse_steps(steps, step_count(run.file), run.file);
    run.windows = {{range.begin, range.end - range.begin}};
  }
}

std::vector<std::string> ExperimentOptions::arguments_of(const std::string& name) const {
  std::vector<std::string> words = {"experiment", "run", name, "--output=" + output, full ? "--full" : "--quick"};
  if (!pipelines.empty()) words.push_back(fmt::format("--pipelines={}", fmt::join(pipelines, ",")));
  if (!scenes.empty()) words.push_back(fmt::format("--scenes={}", fmt::join(scenes, ",")));
  for (const std::string& setting : settings) words.push_back("--set=" + setting);
  if (!steps.empty()) words.push_back("--steps=" + steps);
  if (rounds > 0) words.push_back(fmt::format("--rounds={}", rounds));
  if (threads) words.push_back(fmt::format("--threads={}", *threads));
  if (report.quiet || report.json) words.emplace_back("--quiet");
  return words;
}

std::vector<std::pair<std::string, ExperimentOptions>> experiment_jobs(const ExperimentOptions& options) {
  std::vector<std::pair<std::string, ExperimentOptions>> jobs;
  for (const std::string& name : options.names) {
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
  return jobs;
}

}  // namespace volccd
