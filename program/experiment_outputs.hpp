// What `volccd experiment run` writes: the folder of records, and results for --json.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/experiments/harness/plan.hpp>
#include <volccd/program/experiment_options.hpp>

namespace volccd {

/// Throws InputError if the folder cannot be created.
void make_folder(const std::string& folder);

/// The file of an experiment in the folder of the options.
std::string record_file(const ExperimentOptions& options, const std::string& name, const char* suffix);

/// Refuses files that cannot be written, or that are inputs (OutputPlan). Called before anything is measured.
void check_outputs(const ExperimentOptions& options, const std::string& name, const ExperimentPlan& experiment = {});

/// Hours of measurements are not replaced by minutes, nor measurements of the experiment's scenes by those of others,
/// nor these by those: throws ConfigError. Called before anything is measured.
void protect_other_record(const ExperimentOptions& options, const std::string& name);

/// The results of the experiments, for --json.
using Finished = std::vector<nlohmann::json>;

void add_finished(const std::string& name, const std::string& record, bool complete, const std::string& text,
                  Finished& finished);

}  // namespace volccd
