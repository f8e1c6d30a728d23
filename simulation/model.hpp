// The input of a simulation: a mesh, its materials, and its loads. SI units: m, kg, s, N, Pa.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd::simulation {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// An isotropic material. It is elastic (compressible neo-Hookean) up to the yield stress, and then follows J2
/// plasticity with linear isotropic hardening; at strain rates above the reference rate, the yield stress is multiplied
/// by 1 + rate_factor ln(rate / reference_rate).
struct Material {
  double density = 1000;
  double youngs_modulus = 1e6;
  double poisson_ratio = 0.3;
  double yield_stress = kNever;
  double hardening_modulus = 0;  ///< stress over equivalent plastic strain
  double rate_factor = 0;
  double reference_rate = 1;        ///< 1/s
  double failure_stress = kNever;   ///< greatest principal stress at a vertex at which it splits
  double failure_strain = kNever;   ///< equivalent plastic strain at which a vertex under tension splits
  double breaking_strain = kNever;  ///< equivalent plastic strain at which a hexahedron breaks in two
  double merging_force = kNever;    ///< contact force above which touching vertices merge
  double merging_distance = 0;      ///< greatest distance of two vertices that merge
  double friction = 0;              ///< Coulomb's coefficient; the smaller one of two bodies counts
  double restitution = 0;           ///< 0: contacts are inelastic; the smaller one of two bodies counts
  double damping = 0;               ///< 1/s, proportional to mass
};

/// All elements of one object id.
struct Body {
  std::string name;
  Material material;
  double thickness = 0;  ///< of the shells of the body
  bool rigid = false;    ///< whether it moves as a rigid body, with the mass of its elements
};

/// A fixed half-space: no vertex may enter the region (x - point) . normal < 0. `normal` has length 1.
struct Wall {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  double friction = 0;
};

/// A pressure on the shells of a body. Positive pressure acts along the normal that follows from the node order.
struct Pressure {
  std::int32_t object = 0;
  std::vector<std::pair<double, double>> curve;  ///< (time, pressure), ascending; linear between, constant beyond
};

/// A blade whose edge moves from `point` along `direction` (unit), in the plane with unit normal `normal`. It cuts the
/// part of the plane that its edge has passed. All coordinates refer to the object at rest.
struct Cut {
  std::int32_t object = 0;
  Vec3 point = Vec3::Zero(), direction = Vec3::UnitX(), normal = Vec3::UnitZ();
  double begin = 0;   ///< time at which the edge is at `point`
  double speed = 1;   ///< of the edge
  double length = 1;  ///< distance after which the edge stops
};

/// The given path of a rigid body, which is moved without rotation, whatever acts on it. Its displacement from its
/// initial position is linear between the points and constant beyond them, and zero at time 0.
struct Guide {
  std::int32_t object = 0;
  std::vector<std::pair<double, Vec3>> path;  ///< (time, displacement), times ascending

  Vec3 displacement(double time) const;
};

struct Model {
  Mesh mesh;  ///< solids: tetrahedra, hexahedra; shells: triangles (quads are refused). Objects index `bodies`.
  std::vector<Vec3> positions;   ///< by vertex
  std::vector<Vec3> velocities;  ///< by vertex
  std::vector<Body> bodies;      ///< by object id
  std::vector<Index> fixed;      ///< vertices that do not move
  std::vector<Wall> walls;
  std::vector<Pressure> pressures;
  std::vector<Cut> cuts;
  std::vector<Guide> guides;  ///< at most one for each body
  Vec3 gravity = Vec3::Zero();
};

}  // namespace volccd::simulation
