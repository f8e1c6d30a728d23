// Material law of shells at one point, for the cases that vector kernels leave to scalar code (yielding, large
// stretches).
#pragma once

#include <array>

#include <volccd/simulation/model.hpp>

namespace volccd::simulation::detail {

/// Outside these elastic stretches the logarithm is replaced by its tangent at the limit.
inline constexpr double kMinStretch = 0.2, kGreatestStretch = 5;
/// Plastic flow stops in a triangle that is compressed or stretched by this factor; it is elastic beyond that.
inline constexpr double kGreatestFlow = 10;
/// Viscosity, as a fraction of critical damping at an element's highest frequency.
inline constexpr double kShellDamping = 0.05;

/// Constants of a body.
struct ShellLaw {
  double thickness = 0, density = 0;
  double youngs_modulus = 0, poisson_ratio = 0;
  double plane_modulus = 0;  ///< E / (1 - nu^2)
  double bending = 0;        ///< plate stiffness, N m
  double yield_stress = kNever, hardening_modulus = 0, rate_factor = 0, reference_rate = 1;
  bool rigid = false;

  ShellLaw() = default;
  /// Throws InputError, naming the body by `object`.
  ShellLaw(const Body& body, std::int32_t object);
};

/// Principal logarithmic strain of a squared stretch, and the factor that takes the principal Kirchhoff stress to the
/// second Piola-Kirchhoff stress.
struct PrincipalStrain {
  double strain, factor;
  explicit PrincipalStrain(double squared_stretch);
};

/// One step of one triangle. Principal values are those of the trial state: the present deformation with the plastic
/// flow so far.
struct MembraneStep {
  double squared_stretch[2];  ///< in, [0] >= [1]
  double stress[2];           ///< out: second Piola-Kirchhoff, on the trial reference shape
  double kirchhoff[2];        ///< out
  double flow[2];             ///< out: increment of the principal plastic strain
  double energy;              ///< out: elastic energy per volume at rest
  double plastic_work;        ///< out: of this step, per volume at rest
  double plastic_strain;      ///< out: increment of the equivalent plastic strain
};

/// Elastic response, and response with return mapping. `strain`: equivalent plastic strain before. dt = 0: elastic.
void elastic_membrane(const ShellLaw& law, MembraneStep& step);
void return_membrane(const ShellLaw& law, double strain, double dt, MembraneStep& step);

/// Plastic rotation (>= 0) of a hinge whose trial moment has magnitude `moment` > `capacity`; `slope` = increase of the
/// capacity, `strain` = plastic strain, each per angle of plastic rotation.
struct HingeStep {
  double stiffness, moment, capacity, slope, strain, dt;
};
double hinge_flow(const ShellLaw& law, const HingeStep& step);

/// The rate factor of the yield stress: 1 + C ln(rate / reference), at least 1.
double rate_raise(const ShellLaw& law, double plastic_strain, double dt);

}  // namespace volccd::simulation::detail
