// Scene `builtin`: what stands in for a real penetration run where no data is at hand.
#pragma once

#include <volccd/experiments/scenes/scene.hpp>

namespace volccd {

struct BuiltinConfig {
  int elements = 1530;  ///< hexahedra, about: the numbers along each side are rounded
  int steps = 9;        ///< frames; more frames show the same event more finely
};

/// A block of hexahedra (object 1) hits a plate of hexahedra (object 2) at an angle and goes through it, by formula,
/// not by physics; elements of both erode on the way. Made to resemble a penetration run of a solver: by default the
/// block moves by up to three of its edges a step, the gap closes within the first motion, elements pass through each
/// other before they erode, none erodes before frame 2, faces are not planar. Throws ConfigError.
std::unique_ptr<Scene> make_builtin(const BuiltinConfig& config = {});

SceneDescriptor describe_builtin();

}  // namespace volccd
