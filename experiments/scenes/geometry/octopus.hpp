// An octopus as an implicit solid.
#pragma once

#include <cstdint>

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>

namespace volccd {

struct OctopusPose {
  std::uint64_t seed = 1;  ///< determines length, sway and curl of each tentacle
  double droop = 0.7;      ///< radians below the horizontal at which tentacles leave the body: 1.57 is straight down
  /// Least thickness of tentacles in metres, so that a mesh with edges not much longer than this can represent them.
  double thinnest = 0.008;
};

/// Head up along z with its eyes towards x, the root of the tentacles about the origin; metres, about 0.3 across: a
/// bag-like mantle, two eyes, and eight tapering tentacles, evenly distributed around it, each with a different curve
/// and a rolled-up end. Webs connect the tentacles where they meet each other and the body.
ImplicitSolid octopus_solid(const OctopusPose& pose);

}  // namespace volccd
