// Scene `builtin`: replaces a real penetration run if no data is available.
#pragma once

#include <volccd/experiments/scenes/scene.hpp>

namespace volccd {

struct BuiltinConfig {
  int elements = 1530;  ///< approximate number of hexahedra
  int frames = 9;       ///< more frames show the same event in smaller steps
};

/// A block of hexahedra (object 1) hits a plate of hexahedra (object 2) at an angle and passes through it. The motion
/// is given by formulas, not simulated; elements of both bodies are removed on the way. It resembles a penetration run
/// of a solver: by default the block moves by up to three of its edges in each step, the gap closes within the first
/// step, elements pass through each other before they are removed, none is removed before frame 2, and faces are not
/// planar. Throws ConfigError.
std::unique_ptr<Scene> make_builtin(const BuiltinConfig& config = {});

SceneDescriptor describe_builtin();

}  // namespace volccd
