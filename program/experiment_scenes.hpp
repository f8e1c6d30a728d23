// `volccd experiment run scenes`, which is not in the catalog of experiments.
#pragma once

#include <volccd/program/experiment_outputs.hpp>

namespace volccd {

/// Makes a record for each simulated scene that is no variant of another. Complete records are kept if a scene fails or
/// is interrupted. Returns the exit code.
int run_scenes(const ExperimentOptions& options, Finished& finished);

}  // namespace volccd
