// Scene `crash`: the front of a car hits a rigid wall.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kCrashElements = 60'000, kCrashQuickElements = 5'000;
inline constexpr int kCrashFrames = 66;  ///< 0.44 ms apart
inline constexpr double kCrashDuration = 28.6e-3;

/// Objects: VehiclePart, then the wall. Steel sheet of 0.8 to 3 mm, with plasticity; engine and rear are rigid, and the
/// rear has the mass of the parts that are not modelled. The car moves along -x at 20 m/s and is 15 mm away from the
/// wall at the start: a sheet of 10 mm in a plane normal to x, rigid and fixed, with triangles about as large as those
/// of the car. About `elements` triangles (within 3 %), of which about a tenth are the wall's; refining keeps the
/// geometry. The density of deformable parts is multiplied by 4 (mass scaling, which doubles the time step); the total
/// mass of the car, about 900 kg, is that of a small one. Vertices of the car are moved by up to 1 % of an edge, drawn
/// from the seed. Throws ConfigError unless 2,000 <= elements <= 10^7.
simulation::Model crash_model(int elements = kCrashElements, std::uint64_t seed = 1);

}  // namespace volccd
