// The list of simulated scenes for the program, the tests and the experiments.
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
  int frames = 0;       ///< by default; any number shows the same event, in smaller or larger steps
  double begin = 0;     ///< s: time of the first frame; the simulation before it is not stored
  double duration = 0;  ///< s, from there on
  simulation::SimulationOptions options = {};
  std::string variant_of = {};  ///< scene from which this one differs in the options only; empty: none
  /// Must be increased whenever the frames for the same arguments change, so that older files in the cache are not
  /// used.
  int version = 1;
};

/// octopi, bullet, airbag, crash, liver, which stand for the paper's; then weld, and variants of the bullet.
const std::vector<SimulatedScene>& simulated_scenes();

/// The scene of this name, null if there is none.
const SimulatedScene* find_simulated_scene(const std::string& name);

}  // namespace volccd
