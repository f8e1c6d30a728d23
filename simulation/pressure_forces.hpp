// Pressure loads on the shells of a part.
#pragma once

#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// The loads of Model::pressures: on each triangle of the part (rigid parts included), the pressure of the moment times
/// the triangle's area as it is now, along its normal as it is numbered, a third to each vertex. On a closed surface
/// they sum to zero, force and moment, whatever its shape. Several loads on one part add up. Not thread-safe.
class PressureForces {
 public:
  /// Throws InputError: a curve that is empty, not ascending in time or not finite; a part that does not exist.
  explicit PressureForces(const Model& model);

  /// Adds the forces at positions `x` and time `time` to `force`; returns the power they have at velocities `v`, W. Bit
  /// for bit the same for any number of threads. O(loaded triangles), no allocation.
  double add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double time, Executor& executor,
                    std::span<Vec3> force);

  /// After an edit of the mesh. O(mesh).
  void update(const Mesh& mesh);

  bool empty() const { return triangles_.empty(); }

 private:
  struct Triangle {
    Index vertices[3];
    Index load;  ///< index into loads_
  };

  std::vector<Pressure> loads_;
  std::vector<double> pressure_;  ///< now, a load
  std::vector<Triangle> triangles_;
  std::vector<Index> vertices_;  ///< those of loaded triangles
  std::vector<Index> offsets_;   ///< CSR: triangles at each of vertices_
  std::vector<Index> incidence_;
  std::vector<Vec3> shares_;         ///< force on each vertex of a triangle
  std::vector<double> block_power_;  ///< summed in order, so that threads do not matter
};

/// Pressure of a load's curve at a time: linear between its points, constant beyond.
double pressure_at(const Pressure& load, double time);

}  // namespace volccd::simulation
