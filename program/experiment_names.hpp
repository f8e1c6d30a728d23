// The experiments that `volccd experiment` runs and shows.
#pragma once

#include <string>

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The only experiment that is not in the catalog: its record is a list of simulated scenes, which is not resumed.
inline constexpr const char* kScenesExperiment = "scenes";
inline constexpr const char* kScenesDescription =
    "the simulated scenes: sizes, motion, contacts, edits, energy (--quick: the small sizes)";

/// The folder of records that `run` writes and `table` reads by default. The repository keeps its records in results/.
inline constexpr const char* kDefaultResults = "build/results";

/// The experiment of the catalog with this name, or null.
const ExperimentKind* find_kind(const std::string& name);

/// Throws a ConfigError that lists all names and suggests one. `what`: "experiment", "tables of".
[[noreturn]] void unknown_experiment(const char* what, const std::string& name);

}  // namespace volccd
