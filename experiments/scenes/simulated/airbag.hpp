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
/// 0.66 m across, its sides folded in zigzag onto the middle), 2 the steering wheel below it (rigid, held). The
/// pressure in the bag rises; the middle of its bottom, where the gas enters, is fixed. Layers are about 1.2 mm apart
/// at rest; a first pressure pulse presses them onto each other. About `elements` triangles (within 3 %). The fabric
/// has random initial velocities of up to 0.2 m/s, drawn from the seed. Throws ConfigError unless 1,200 <= elements <=
/// 10^7.
simulation::Model airbag_model(int elements = kAirbagElements, std::uint64_t seed = 1);

}  // namespace volccd
