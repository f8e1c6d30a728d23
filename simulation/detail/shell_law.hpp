// Material law of shells at one point: what the vector kernels leave to scalar code (yielding, great stretches).
#pragma once

#include <array>

#include <volccd/simulation/model.hpp>

namespace volccd::simulation::detail {

/// Elastic stretches outside [1/5, 5] get the tangent of the logarithm there.
inline constexpr double kLeastStretch = 0.2, kGreatestStretch = 5;
/// Plastic flow stops in a triangle squashed or drawn out this many times: it is elastic from there on.
inline constexpr double kGreatestFlow = 10;
/// Viscosity, as a share of the critical at an element's highest frequency.
inline constexpr double kShellDamping = 0.05;

/// A part's constants.
struct ShellLaw {
  double thickness = 0, density = 0;
  double youngs_modulus = 0, poisson_ratio = 0;
  double plane_modulus = 0;  ///< E / (1 - nu^2)
  double bending = 0;        ///< plate stiffness, N m
  double yield_stress = kNever, hardening_modulus = 0, rate_factor = 0, reference_rate = 1;
  bool rigid = false;

  ShellLaw() = default;
  /// Throws InputError, naming the part by `object`.
  ShellLaw(const Part& part, std::int32_t object);
};

/// Principal logarithmic strain of a squared stretch, and the factor that takes the principal Kirchhoff stress to the
/// second Piola-Kirchhoff stress.
struct PrincipalStrain {
  double strain, factor;
  explicit PrincipalStrain(double squared_stretch);
};

/// One step at one triangle. Principal values are of the trial: the deformation with the plastic flow so far.
struct MembraneStep {
  double squared_stretch[2];  ///< in, [0] >= [1]
  double stress[2];           ///< out: second Piola-Kirchhoff, on the trial reference shape
  double kirchhoff[2];        ///< out
  double flow[2];             ///< out: increment of the principal plastic strain
  double energy;              ///< out: elastic, a volume at rest
  double plastic_work;        ///< out: of this step, a volume at rest
  double plastic_strain;      ///< out: increment of the equivalent
};

/// `strain`: equivalent plastic strain before. dt = 0: elastic.
void elastic_membrane(const ShellLaw& law, MembraneStep& step);
void return_membrane(const ShellLaw& law, double strain, double dt, MembraneStep& step);

/// Plastic rotation (>= 0) of a hinge whose trial moment has magnitude `moment` > `capacity`; `slope` = increase of the
/// capacity, `strain` = plastic strain, each per angle of plastic rotation.
struct HingeStep {
  double stiffness, moment, capacity, slope, strain, dt;
};
double hinge_flow(const ShellLaw& law, const HingeStep& step);

/// 1 + C ln(rate / reference), at least 1.
double rate_raise(const ShellLaw& law, double plastic_strain, double dt);

}  // namespace volccd::simulation::detail
