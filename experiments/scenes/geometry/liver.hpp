// A liver as an implicit solid.
#pragma once

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>

namespace volccd {

/// Metres, about 0.24 x 0.11 x 0.15 around the origin, as in a standing person seen from the front (from -y, z up): the
/// large right lobe at x < 0, the small flat left one at x > 0, domed above and in front, hollow behind and below, a
/// sharp edge at the bottom, and there a notch between the lobes.
ImplicitSolid liver_solid();

}  // namespace volccd
