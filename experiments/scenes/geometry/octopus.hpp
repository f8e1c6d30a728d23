// An octopus as an implicit solid.
#pragma once

#include <cstdint>

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>

namespace volccd {

struct OctopusPose {
  std::uint64_t seed = 1;  ///< each tentacle's length, sway and curl
  double droop = 0.7;      ///< radians below the horizontal at which tentacles leave the body: 1.57 is straight down
  /// Tentacles taper no further: what a mesh of edges not much longer than this can hold on to. Metres.
  double thinnest = 0.008;
};

/// Head up along z with its eyes towards x, the root of the tentacles about the origin; metres, about 0.3 across: a
/// bag-like mantle, two eyes, and eight tapering tentacles that leave it evenly all around, each on a way of its own,
/// their ends rolled up. Where tentacles meet each other and the body there is a web.
ImplicitSolid octopus_solid(const OctopusPose& pose);

}  // namespace volccd
