// Scene `bullet`: a copper bullet perforates a steel plate.
#pragma once

#include <cstdint>

#include <volccd/simulation/model.hpp>

namespace volccd {

inline constexpr int kBulletElements = 11'800, kBulletQuickElements = 1'500;
inline constexpr int kBulletFrames = 65;  ///< 0.8 microseconds apart: 0.6 mm at first, edges are 0.8 to 1.2 mm
inline constexpr double kBulletDuration = 51.2e-6;

/// Objects: 0 the bullet (copper, 10 mm x 24 mm, round-nosed, 750 m/s along -z), 1 the plate (steel, 100 mm x 100 mm x
/// 5 mm, held along its rim, finer in the middle). Both yield, harden, and split where their strain is too large. About
/// `elements` hexahedra (within 3 %). The seed determines a small yaw and offset of the bullet, and moves inner
/// vertices of the plate by up to 4 % of their cells. Throws ConfigError unless 500 <= elements <= 10^7.
simulation::Model bullet_model(int elements = kBulletElements, std::uint64_t seed = 1);

}  // namespace volccd
