// Scenes that come from a simulation, as the program, the tests and the experiments know them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <volccd/simulation/simulation.hpp>

namespace volccd {

struct SimulatedScene {
  std::string name;
  std::string description;  ///< one line
  /// The scene with about this many elements. The same arguments give the same model. Throws ConfigError.
  simulation::Model (*model)(int elements, std::uint64_t seed) = nullptr;
  int default_elements = 0, quick_elements = 0;
  int frames = 0;       ///< by default; any number shows the same event, more or less finely
  double begin = 0;     ///< s: the first frame; what comes before is simulated and not kept
  double duration = 0;  ///< s, from there on
  simulation::SimulationOptions options;
  std::string variant_of = {};  ///< the scene that this one is but for the options; empty: none
  /// To be raised whenever other frames come out for the same arguments: files baked before are not used any more.
  int version = 1;
};

/// octopi, bullet, airbag, crash, liver; then the variants of them.
const std::vector<SimulatedScene>& simulated_scenes();

/// Null: none has this name.
const SimulatedScene* find_simulated_scene(const std::string& name);

}  // namespace volccd
