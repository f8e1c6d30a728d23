// What a simulation starts from: a mesh, what it is made of, and what acts on it. SI units: m, kg, s, N, Pa.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <volccd/mesh/mesh.hpp>

namespace volccd::simulation {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// Isotropic. Elastic (compressible neo-Hookean) unless it yields; then J2 plasticity with linear isotropic hardening,
/// its yield stress raised by the factor 1 + rate_factor ln(rate / reference_rate) at strain rates above the reference.
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
  double breaking_strain = kNever;  ///< the same, at which a hexahedron breaks in two (element_breaking.hpp)
  double merging_force = kNever;    ///< force of a contact at which vertices in touch merge
  double merging_distance = 0;      ///< how near two vertices must be to merge
  double friction = 0;              ///< Coulomb's coefficient; of two parts in contact, the smaller
  double restitution = 0;           ///< 0: contacts are inelastic; of two parts, the smaller
  double damping = 0;               ///< 1/s, proportional to mass
};

/// All elements of one object id.
struct Part {
  std::string name;
  Material material;
  double thickness = 0;  ///< of shells; not used by solids
  bool rigid = false;    ///< moves as one body; mass and inertia are those of its elements
};

/// Fixed half-space behind a plane: nothing gets to where (x - point) . normal < 0. `normal` has length 1.
struct Wall {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  double friction = 0;
};

/// On the shells of a part, along their normals as the vertices are numbered (positive pushes along the normal).
struct Pressure {
  std::int32_t object = 0;
  std::vector<std::pair<double, double>> curve;  ///< (time, pressure), ascending; linear between, constant beyond
};

/// A blade whose edge moves from `point` along `direction` (unit), in the plane with unit normal `normal`: what lies
/// behind the edge, between depth 0 and the length covered, is parted. All as the object lies at rest.
struct Cut {
  std::int32_t object = 0;
  Vec3 point = Vec3::Zero(), direction = Vec3::UnitX(), normal = Vec3::UnitZ();
  double begin = 0;   ///< time at which the edge is at `point`
  double speed = 1;   ///< of the edge
  double length = 1;  ///< where it stops
};

struct Model {
  Mesh mesh;  ///< solids: tetrahedra, hexahedra; shells: triangles (quads are refused). Objects index `parts`.
  std::vector<Vec3> positions;   ///< a vertex
  std::vector<Vec3> velocities;  ///< a vertex
  std::vector<Part> parts;       ///< by object id
  std::vector<Index> fixed;      ///< vertices that are held where they are
  std::vector<Wall> walls;
  std::vector<Pressure> pressures;
  std::vector<Cut> cuts;
  Vec3 gravity = Vec3::Zero();
};

}  // namespace volccd::simulation
