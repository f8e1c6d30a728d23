#include <volccd/simulation/elements/detail/shell_law.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/simulation/detail/portable_math.hpp>

namespace volccd::simulation::detail {
namespace {

struct Slope {
  double value, slope;
};

/// Root of a function that is strictly decreasing, positive at 0 and negative for large arguments. Newton's method,
/// with bisection if a step would leave the bracket. `scale` is the initial guess, > 0.
template <typename Function>
double falling_root(const Function& f, double scale) {
  double lo = 0, hi = scale;
  for (int k = 0; k < 200 && f(hi).value > 0; ++k) {
    lo = hi;
    hi *= 2;
  }
  double x = hi;
  for (int k = 0; k < 100; ++k) {
    const Slope at = f(x);
    (at.value > 0 ? lo : hi) = x;
    double next = x - at.value / at.slope;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    const bool done = std::fabs(next - x) <= 4e-16 * x;
    x = next;
    if (done || !(hi - lo > 4e-16 * hi)) break;
  }
  return x;
}

/// Logarithmic increase of the yield stress at a plastic strain increment, with its derivative.
Slope raise_at(const ShellLaw& law, double increment, double dt) {
  const double still = law.reference_rate * dt;
  if (law.rate_factor == 0 || increment <= still) return {1, 0};
  return {1 + law.rate_factor * portable_log(increment / still), law.rate_factor / increment};
}

Slope yield_at(const ShellLaw& law, double strain, double increment, double dt) {
  const double base = law.yield_stress + law.hardening_modulus * (strain + increment);
  const Slope raise = raise_at(law, increment, dt);
  return {base * raise.value, law.hardening_modulus * raise.value + base * raise.slope};
}

double equivalent(const double (&stress)[2]) {
  return std::sqrt(stress[0] * stress[0] + stress[1] * stress[1] - stress[0] * stress[1]);
}

double energy_of(const ShellLaw& law, const double (&stress)[2]) {
  return (stress[0] * stress[0] + stress[1] * stress[1] - 2 * law.poisson_ratio * stress[0] * stress[1]) /
         (2 * law.youngs_modulus);
}

void require(bool good, std::int32_t object, const char* problem) {
  if (!good) throw InputError("model", "bodies", object, problem);
}

}  // namespace

ShellLaw::ShellLaw(const Body& body, std::int32_t object)
    : thickness(body.thickness),
      density(body.material.density),
      youngs_modulus(body.material.youngs_modulus),
      poisson_ratio(body.material.poisson_ratio),
      yield_stress(body.material.yield_stress),
      hardening_modulus(body.material.hardening_modulus),
      rate_factor(body.material.rate_factor),
      reference_rate(body.material.reference_rate),
      rigid(body.rigid) {
  require(std::isfinite(thickness) && thickness > 0, object, "has shells, and no positive thickness");
  require(std::isfinite(density) && density > 0, object, "has no positive density");
  if (rigid) return;
  require(std::isfinite(youngs_modulus) && youngs_modulus > 0, object, "has no positive Young's modulus");
  require(poisson_ratio > -1 && poisson_ratio <= 0.5, object, "Poisson's ratio is not in (-1, 1/2]");
  require(yield_stress > 0, object, "has no positive yield stress");
  require(std::isfinite(hardening_modulus) && hardening_modulus >= 0, object, "has a negative hardening modulus");
  require(std::isfinite(rate_factor) && rate_factor >= 0, object, "has a negative rate factor");
  require(rate_factor == 0 || (std::isfinite(reference_rate) && reference_rate > 0), object,
          "has a rate factor, and no positive reference rate");
  plane_modulus = youngs_modulus / (1 - poisson_ratio * poisson_ratio);
  bending = plane_modulus * thickness * thickness * thickness / 12;
}

PrincipalStrain::PrincipalStrain(double squared_stretch) {
  constexpr double min = kMinStretch * kMinStretch, greatest = kGreatestStretch * kGreatestStretch;
  if (squared_stretch >= min && squared_stretch <= greatest) {
    strain = half_log(squared_stretch);
    factor = 1 / squared_stretch;
    return;
  }
  const double bound = squared_stretch < 1 ? kMinStretch : kGreatestStretch;
  const double stretch = std::sqrt(std::max(squared_stretch, 0.0));
  strain = half_log(bound * bound) + (stretch - bound) / bound;
  // At stretch 0 the force has no direction; it is reduced to zero there.
  factor = 1 / (bound * std::max(stretch, 1e-9));
}

void elastic_membrane(const ShellLaw& law, MembraneStep& step) {
  const PrincipalStrain first(step.squared_stretch[0]), second(step.squared_stretch[1]);
  step.kirchhoff[0] = law.plane_modulus * (first.strain + law.poisson_ratio * second.strain);
  step.kirchhoff[1] = law.plane_modulus * (second.strain + law.poisson_ratio * first.strain);
  step.stress[0] = step.kirchhoff[0] * first.factor;
  step.stress[1] = step.kirchhoff[1] * second.factor;
  step.flow[0] = step.flow[1] = step.plastic_work = step.plastic_strain = 0;
  step.energy = energy_of(law, step.kirchhoff);
}

void return_membrane(const ShellLaw& law, double strain, double dt, MembraneStep& step) {
  elastic_membrane(law, step);
  const double trial = equivalent(step.kirchhoff);
  if (!(dt > 0) || trial <= law.yield_stress + law.hardening_modulus * strain) return;
  // The sum and the difference of the principal stresses are reduced independently (Simo and Taylor 1986).
  const double sum = step.kirchhoff[0] + step.kirchhoff[1], difference = step.kirchhoff[0] - step.kirchhoff[1];
  const double sum_rate = law.youngs_modulus / (2 * (1 - law.poisson_ratio));
  const double difference_rate = 1.5 * law.youngs_modulus / (1 + law.poisson_ratio);
  const auto excess = [&](double multiplier) -> Slope {
    const double s = 1 / (1 + multiplier * sum_rate), d = 1 / (1 + multiplier * difference_rate);
    const double a = 0.25 * sum * sum * s * s, b = 0.75 * difference * difference * d * d;
    const double stress = std::sqrt(a + b), falls = -(a * s * sum_rate + b * d * difference_rate) / stress;
    const Slope yield = yield_at(law, strain, multiplier * stress, dt);
    return {stress - yield.value, falls - yield.slope * (stress + multiplier * falls)};
  };
  const double multiplier = falling_root(excess, (trial / law.yield_stress - 1) / difference_rate + 1e-300);
  const double new_sum = sum / (1 + multiplier * sum_rate),
               new_difference = difference / (1 + multiplier * difference_rate);
  const PrincipalStrain first(step.squared_stretch[0]), second(step.squared_stretch[1]);
  step.kirchhoff[0] = 0.5 * (new_sum + new_difference);
  step.kirchhoff[1] = 0.5 * (new_sum - new_difference);
  step.stress[0] = step.kirchhoff[0] * first.factor;
  step.stress[1] = step.kirchhoff[1] * second.factor;
  step.flow[0] = multiplier * (step.kirchhoff[0] - 0.5 * step.kirchhoff[1]);
  step.flow[1] = multiplier * (step.kirchhoff[1] - 0.5 * step.kirchhoff[0]);
  step.plastic_strain = multiplier * equivalent(step.kirchhoff);
  const double middle = law.yield_stress + law.hardening_modulus * (strain + 0.5 * step.plastic_strain);
  step.plastic_work = step.plastic_strain * middle * raise_at(law, step.plastic_strain, dt).value;
  step.energy = energy_of(law, step.kirchhoff);
}

double hinge_flow(const ShellLaw& law, const HingeStep& step) {
  const double still = (step.moment - step.capacity) / (step.stiffness + step.slope);
  if (law.rate_factor == 0) return still;
  const auto excess = [&](double angle) -> Slope {
    const Slope raise = raise_at(law, step.strain * angle, step.dt);
    const double capacity = step.capacity + step.slope * angle;
    return {step.moment - step.stiffness * angle - capacity * raise.value,
            -step.stiffness - step.slope * raise.value - capacity * raise.slope * step.strain};
  };
  return falling_root(excess, still);
}

double rate_raise(const ShellLaw& law, double plastic_strain, double dt) {
  return raise_at(law, plastic_strain, dt).value;
}

}  // namespace volccd::simulation::detail
