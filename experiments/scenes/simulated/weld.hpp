// Scene `weld`: a plate is shot at another, welds to it, and reflected waves crack it inside: merging and
// splitting by stress (Algorithm 1, lines 27 to 38; Figure 2).
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kWeldElements = 4'000, kWeldQuickElements = 800;
inline constexpr int kWeldFrames = 61;  ///< 0.2 us apart
inline constexpr double kWeldDuration = 12e-6;

/// Object 0: a flyer plate of aluminium, about 12 x 12 x 2 mm, at 300 m/s. Object 1: a free plate of the same material,
/// about 16 x 16 x 4 mm. Where the flyer hits, vertices that are near each other merge under the force of the contact.
/// The release waves of both backs meet inside the target, which spalls there: its vertices split at the failure
/// stress. About `elements` cubes (within a third). The flyer is turned about its normal and tilted by less than a
/// degree, drawn from the seed, so that most of its vertices are near those of the target, and none are in the same
/// place. Throws ConfigError unless 300 <= elements <= 10^6.
simulation::Model weld_model(int elements = kWeldElements, std::uint64_t seed = 1);

}  // namespace volccd
