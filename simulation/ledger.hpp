// What a simulation must account for: energy, momentum, angular momentum and mass.
#pragma once

#include <span>

#include <volccd/mesh/types.hpp>

namespace volccd::simulation {

/// At a moment; what is "so far" adds up from the start of the simulation. J, kg m/s, kg m^2/s (about the origin), kg.
///
/// Leapfrog knows positions at the ends of steps and velocities in between. Kinetic energy is the product of the
/// velocities before and after the moment, half the mass: of a linear elastic body its sum with the elastic energy
/// stays exact. Momentum and angular momentum are those of the velocity before.
struct Ledger {
  double time = 0;

  double kinetic = 0, elastic = 0;

  double plastic = 0;    ///< so far: work of plastic deformation
  double numerical = 0;  ///< so far: taken by hourglass control and bulk viscosity
  double damping = 0;    ///< so far: taken by Material::damping
  double contact = 0;    ///< so far: taken by contacts and walls, friction not; less what moving vertices apart put in
  double friction = 0;   ///< so far
  double topology = 0;   ///< so far: energy lost where vertices merged, split or were cut apart
  double external = 0;   ///< so far: work of gravity and pressure
  double initial = 0;    ///< kinetic and elastic at the start

  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();
  /// So far, from outside: gravity, pressure, damping, walls and what holds fixed vertices.
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
  double mass = 0;

  /// What is unaccounted for; 0 if nothing is.
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
