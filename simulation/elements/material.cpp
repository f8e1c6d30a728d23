#include <volccd/simulation/elements/material.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/simulation/detail/portable_math.hpp>

namespace volccd::simulation {

void check_material(const Material& m, const std::string& body) {
  const auto require = [&](bool holds, const char* what) {
    if (!holds) throw InputError("model", "material of body '" + body + "'", what);
  };
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  const auto not_negative = [](double value) { return value >= 0 && std::isfinite(value); };
  require(positive(m.density), "density must be positive");
  require(positive(m.youngs_modulus), "Young's modulus must be positive");
  require(m.poisson_ratio > -1 && m.poisson_ratio < 0.5, "Poisson's ratio must be between -1 and 0.5");
  require(m.yield_stress > 0, "yield stress must be positive");
  require(not_negative(m.hardening_modulus), "hardening modulus must not be negative");
  require(not_negative(m.rate_factor), "rate factor must not be negative");
  require(positive(m.reference_rate), "reference rate must be positive");
  require(m.failure_stress > 0 && m.failure_strain > 0 && m.breaking_strain > 0,
          "failure stress and strain and breaking strain must be positive");
  require(m.merging_force >= 0, "merging force must not be negative");
  require(not_negative(m.merging_distance) && not_negative(m.friction) && not_negative(m.restitution) &&
              not_negative(m.damping),
          "merging distance, friction, restitution and damping must not be negative");
}

double shear_modulus(const Material& m) { return m.youngs_modulus / (2 * (1 + m.poisson_ratio)); }

double lame_lambda(const Material& m) {
  return m.youngs_modulus * m.poisson_ratio / ((1 + m.poisson_ratio) * (1 - 2 * m.poisson_ratio));
}

double sound_speed(const Material& m) { return std::sqrt((lame_lambda(m) + 2 * shear_modulus(m)) / m.density); }

double yield_stress(const Material& m, double strain, double rate) {
  const double at_rest = m.yield_stress + m.hardening_modulus * strain;
  if (m.rate_factor == 0 || rate <= m.reference_rate) return at_rest;
  return at_rest * (1 + m.rate_factor * detail::portable_log(rate / m.reference_rate));
}

double plastic_increment(const Material& m, double trial, double slope, double scale, double strain, double dt) {
  const double yield = scale * (m.yield_stress + m.hardening_modulus * strain), hardening = scale * m.hardening_modulus;
  if (!(trial > yield)) return 0;
  const double without_rate = (trial - yield) / (slope + hardening), threshold = m.reference_rate * dt;
  if (m.rate_factor == 0 || without_rate <= threshold) return without_rate;
  // The residual decreases from a positive value at the threshold to a negative one at `without_rate`: Newton's steps,
  // kept between.
  double low = threshold, high = without_rate, d = low;
  for (int k = 0; k < 60; ++k) {
    const double factor = 1 + m.rate_factor * detail::portable_log(d / threshold);
    const double left = trial - slope * d - (yield + hardening * d) * factor;
    (left > 0 ? low : high) = d;
    const double descent = slope + hardening * factor + (yield + hardening * d) * m.rate_factor / d;
    double next = d + left / descent;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - d) <= 1e-15 * d) break;
    d = next;
  }
  return d;
}

}  // namespace volccd::simulation
