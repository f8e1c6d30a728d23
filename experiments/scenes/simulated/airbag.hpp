// Scene `airbag`: a folded airbag inflates in front of a steering wheel.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kAirbagElements = 9'100, kAirbagQuickElements = 1'500;
inline constexpr int kAirbagFrames = 81;         ///< 0.24 ms apart
inline constexpr double kAirbagBegin = 0.75e-3;  ///< when the folds have closed
inline constexpr double kAirbagDuration = 19.25e-3;

/// Objects: 0 the sheet on the side of the wheel, 1 the sheet on the driver's, joined at the rim (fabric of 0.35 mm,
/// 0.66 m across, its sides folded in zigzag onto the middle), 2 the steering wheel below it (rigid, held). Pressure
/// rises in the bag, whose bottom is held in the middle, where the gas comes in. Layers are apart by about 1.2 mm at
/// rest; a first blow presses them onto each other. About `elements` triangles (within 3 %). The seed gives the fabric
/// velocities of up to 0.2 m/s at random. Throws ConfigError: elements not in 1,200 .. 10^7.
simulation::Model airbag_model(int elements = kAirbagElements, std::uint64_t seed = 1);

}  // namespace volccd
