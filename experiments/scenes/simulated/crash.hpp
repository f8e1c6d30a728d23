// Scene `crash`: the front of a car hits a rigid wall.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kCrashElements = 60'000, kCrashQuickElements = 5'000;
inline constexpr int kCrashFrames = 66;  ///< 0.44 ms apart
inline constexpr double kCrashDuration = 28.6e-3;

/// Objects: VehiclePart. Steel sheet of 0.8 to 3 mm, with plasticity; engine and rear rigid, the rear as heavy as what
/// the model leaves out. Moves along -x at 20 m/s, 15 mm away from a wall. About `elements` triangles (within 3 %);
/// refining keeps the geometry. Deformable parts have 4 times their density (mass scaling: a step twice as long; the
/// mass in all, about 900 kg, is that of a small car). The seed moves vertices by up to 1 % of an edge. Throws
/// ConfigError: elements not in 2,000 .. 10^7.
simulation::Model crash_model(int elements = kCrashElements, std::uint64_t seed = 1);

}  // namespace volccd
