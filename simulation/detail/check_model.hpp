// Checks of the input of a simulation.
#pragma once

#include <volccd/simulation/simulation.hpp>

namespace volccd::simulation::detail {

/// Throws InputError if lengths, indices or objects of the model are inconsistent, or values are not finite.
void check_model(const Model& model);

/// Throws ConfigError.
void check_options(const SimulationOptions& options);

}  // namespace volccd::simulation::detail
