// Scene `octopi`: three soft octopi are thrown at each other, arms first.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kOctopiElements = 17'600, kOctopiQuickElements = 3'000;
inline constexpr int kOctopiFrames = 97;  ///< 6.25 ms apart: 0.5 to 2 edges at the fast places
inline constexpr double kOctopiDuration = 0.6;

/// Objects 0, 1, 2: octopi of 0.3 m and 1.5 kg, soft, with damping as in water, and with eight tentacles of different
/// shape. They come from three sides with the tentacles ahead, rotate about their axes, meet in the middle and fall
/// into object 3, a rigid funnel that does not move, where they entangle. Nothing touches at first. About `elements`
/// tetrahedra in total (within 3 %), of which about 18 % are the funnel's: their edges are about twice as long as those
/// of the octopi. With few elements the tentacles are thicker, so that they do not break. The seed determines their
/// shapes and the directions of motion. Throws ConfigError unless 1,500 <= elements <= 10^7.
simulation::Model octopi_model(int elements = kOctopiElements, std::uint64_t seed = 1);

}  // namespace volccd
