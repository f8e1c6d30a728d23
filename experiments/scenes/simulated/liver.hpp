// Scene `liver`: a liver that hangs from its sides is cut from below.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kLiverElements = 3'874, kLiverQuickElements = 800;
inline constexpr int kLiverFrames = 81;  ///< 12.5 ms apart: 0.2 to 0.5 edges at the fast places
inline constexpr double kLiverDuration = 1.0;

/// Object 0: a liver of 0.24 m, about 2 kg, of soft tissue, fixed at its upper left and right. It sags for 0.2 s; then
/// a blade moves up through it for 0.5 s, and its weight opens the cut. About `elements` tetrahedra at first (within 3
/// %); the default has 3,864, and is cut to 4,338. The lattice of the mesh is rotated by up to 10 degrees, drawn from
/// the seed. Throws ConfigError unless 300 <= elements <= 10^7.
simulation::Model liver_model(int elements = kLiverElements, std::uint64_t seed = 1);

}  // namespace volccd
