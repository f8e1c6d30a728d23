// Functions of a Material: elastic constants, the yield curve, and the return mapping to it.
#pragma once

#include <string>

#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// Throws InputError (dataset `body`) unless all numbers are in range: density, Young's modulus, yield stress and
/// reference rate positive, -1 < Poisson's ratio < 0.5, the rest not negative; only limits may be infinite.
void check_material(const Material& material, const std::string& body);

/// Lame's constants.
double shear_modulus(const Material& material);
double lame_lambda(const Material& material);

/// Speed of pressure waves in the bulk: sqrt((lambda + 2 mu) / density).
double sound_speed(const Material& material);

/// The yield stress at equivalent plastic strain `strain`, which grows at `rate` (1/s): (yield + hardening strain) (1 +
/// rate_factor ln(rate / reference_rate)), the second factor not below 1.
double yield_stress(const Material& material, double strain, double rate);

/// Radial return: the increment d >= 0 of plastic strain for which `trial` - `slope` d = `scale` yield_stress(strain +
/// d, d / dt), to rounding; 0 if `trial` does not exceed the yield stress at rate 0. Implicit in the rate, so that the
/// rate does not oscillate from step to step. Requires dt > 0 and slope > 0.
double plastic_increment(const Material& material, double trial, double slope, double scale, double strain, double dt);

}  // namespace volccd::simulation
