// Pressure loads on the shells of a body.
#pragma once

#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// The loads of Model::pressures. The force on each triangle of the body (rigid bodies included) is the pressure at the
/// time times the triangle's present area, along the normal that follows from its node order; each vertex gets a third.
/// On a closed surface of any shape, the sums of forces and of moments are zero. Several loads on one body add up. Not
/// thread-safe.
class PressureForces {
 public:
  /// Throws InputError for a curve that is empty, not ascending in time or not finite, and for a body that does not
  /// exist.
  explicit PressureForces(const Model& model);

  /// Adds the forces at positions `x` and time `time` to `force`; returns their power at velocities `v`, in W. Bit for
  /// bit the same for any number of threads. O(loaded triangles), no allocation.
  double add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double time, Executor& executor,
                    std::span<Vec3> force);

  /// To be called after an edit of the mesh. O(mesh).
  void update(const Mesh& mesh);

  bool empty() const { return triangles_.empty(); }

 private:
  struct Triangle {
    Index vertices[3];
    Index load;  ///< index into loads_
  };

  std::vector<Pressure> loads_;
  std::vector<double> pressure_;  ///< present pressure, by load
  std::vector<Triangle> triangles_;
  std::vector<Index> vertices_;  ///< those of loaded triangles
  std::vector<Index> offsets_;   ///< CSR: triangles at each of vertices_
  std::vector<Index> incidence_;
  std::vector<Vec3> shares_;         ///< force on each vertex of a triangle
  std::vector<double> block_power_;  ///< by block; summed in order, so that the sum does not depend on threads
};

/// Pressure of a load's curve at a time: linear between its points, constant beyond.
double pressure_at(const Pressure& load, double time);

}  // namespace volccd::simulation
