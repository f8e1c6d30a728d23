// Balance of energy, momentum, angular momentum and mass of a simulation.
#pragma once

#include <span>

#include <volccd/numerics/types.hpp>

namespace volccd::simulation {

/// The balance at one time; values "so far" are sums from the start of the simulation. Units: J, kg m/s, kg m^2/s
/// (about the origin), kg.
///
/// Leapfrog integration has positions at the ends of steps and velocities in between. The kinetic energy is half the
/// mass times the product of the velocities before and after the time; for a linear elastic body, its sum with the
/// elastic energy is then conserved exactly. Momentum and angular momentum are those of the velocity before.
struct Ledger {
  double time = 0;

  double kinetic = 0, elastic = 0;  ///< without what is fixed or guided

  double plastic = 0;    ///< so far: work of plastic deformation
  double numerical = 0;  ///< so far: dissipated by hourglass control and bulk viscosity
  double damping = 0;    ///< so far: dissipated by Material::damping
  double contact = 0;    ///< so far: lost in contacts and at walls (no friction), less what separating vertices added
  double friction = 0;   ///< so far: dissipated by friction
  double topology = 0;   ///< so far: energy lost where vertices merged, split or were cut apart
  double external = 0;   ///< so far: work of gravity and pressure, and of what moves guided bodies
  double initial = 0;    ///< kinetic and elastic at the start

  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();
  /// So far: impulses of external forces (gravity, pressure, damping, walls, and the forces that hold fixed vertices
  /// and move guided bodies).
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
  double mass = 0;

  /// Error of the energy balance; 0 if all energy is accounted for.
  double balance_error() const {
    return kinetic + elastic + plastic + numerical + damping + contact + friction + topology - external - initial;
  }
};

/// Sums over vertices.
double kinetic_energy(std::span<const double> mass, std::span<const Vec3> v);
Vec3 momentum(std::span<const double> mass, std::span<const Vec3> v);
Vec3 angular_momentum(std::span<const double> mass, std::span<const Vec3> x, std::span<const Vec3> v);
double total(std::span<const double> mass);

}  // namespace volccd::simulation
