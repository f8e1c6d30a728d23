// A steering wheel of shells.
#pragma once

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Rim (a torus about z), hub (a drum) and three spokes, one closed surface without self-intersections, about
/// `triangles` triangles, in the plane z = 0: the rim reaches up to z = 0.014, the hub to 0.010, all within 0.2 of the
/// z axis. Metres. Object 0. Throws ConfigError for too few triangles.
Shape steering_wheel(int triangles);

}  // namespace volccd
