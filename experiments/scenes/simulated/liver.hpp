// Scene `liver`: a liver that hangs from its sides is cut from below.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kLiverElements = 3'874, kLiverQuickElements = 800;
inline constexpr int kLiverFrames = 81;  ///< 7 ms apart
inline constexpr double kLiverBegin = 0.45, kLiverDuration = 0.55;

/// Object 0: a liver of 0.24 m, about 2 kg, of soft tissue, fixed at its upper left and right. It sags and swings for
/// 0.35 s; then the blade of the cut moves up through it, until 0.92 s, and its weight opens the cut. Object 1: a
/// scalpel, rigid, 3 mm thick, that follows a given path behind the edge of the cut, spreads the cut, and stays in it.
/// About `elements` tetrahedra at first (within 3 %), of which the scalpel has about an eighth: their edges are about
/// as long as those of the liver. The default has 3,878, and 4,361 after the cut. The lattice of the liver is rotated
/// by up to 10 degrees, drawn from the seed. Throws ConfigError unless 300 <= elements <= 10^7.
simulation::Model liver_model(int elements = kLiverElements, std::uint64_t seed = 1);

}  // namespace volccd
