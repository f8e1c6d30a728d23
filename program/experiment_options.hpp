// The options of `volccd experiment run`.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/experiment_names.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

struct ExperimentOptions {
  std::vector<std::string> names, pipelines, settings, scenes;
  std::string output = kDefaultResults, steps;
  int rounds = 0;  ///< 0: those of the experiment
  bool quick = false, full = false, skip_complete = false;
  std::optional<unsigned> threads;
  ReportOptions report;

  void add_to(CLI::App& command);

  /// Default: one thread for timed experiments, as in the paper; all threads for simulations.
  unsigned timed_threads() const { return threads.value_or(1); }
  unsigned simulation_threads() const { return threads.value_or(0); }

  /// Sequences of the caller, by the names of their files; by their whole paths if two files have one name. Throws
  /// ConfigError if one is there twice.
  std::vector<TableScene> own_scenes() const;
  /// Makes --steps and --rounds those of all runs. The record has names of files without their folders.
  void change_plan(ExperimentPlan& plan) const;
  /// The arguments with which this program runs the experiment as it does here.
  std::vector<std::string> arguments_of(const std::string& name) const;
};

/// The experiments that the options name, each with the options that it gets. `all` gives additional pipelines and
/// settings to the experiments that support them; its scenes are small unless --full is given. Throws ConfigError for
/// an unknown name, and for options that an experiment would ignore.
std::vector<std::pair<std::string, ExperimentOptions>> experiment_jobs(const ExperimentOptions& options);

}  // namespace volccd
