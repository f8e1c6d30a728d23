// Internal forces of one family of elements (solids, shells): the interface between them and the time loop.
#pragma once

#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// Element slots that a topology edit took and gave. Slots in `added` may be among `removed`.
struct ElementHeritage {
  std::vector<Index> removed;
  std::vector<Index> added;
  /// For each of `added`: the slot, as it was before the edit, of the element whose state it takes over (history,
  /// reference shape as far as it is not given by the reference positions).
  std::vector<Index> parents;
};

/// What the failure criterion looks at, per vertex: sums over the elements at it, weighted by volume.
struct VertexStress {
  Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();  ///< Cauchy, times volume
  double plastic_strain = 0;                         ///< equivalent, times volume
  double volume = 0;
};

/// Looks after the elements of its own family in the mesh, rigid parts left out, and ignores the others. Not
/// thread-safe.
class ElementForces {
 public:
  virtual ~ElementForces() = default;

  /// Adds the lumped masses of ALL elements of the family, those of rigid parts included.
  virtual void add_masses(std::span<double> mass) const = 0;

  /// Adds internal forces at positions `x`, and advances plasticity by the step that led there, of length `dt` with
  /// velocities `v` (dt = 0: no step, nothing advances). Bit for bit the same for any number of threads.
  virtual void add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                          std::span<Vec3> force) = 0;

  /// Largest stable time step (Courant, over its elements, with no safety factor), for the shapes of the last
  /// add_forces().
  virtual double stable_step() const = 0;

  /// Adds to `out` (one a vertex) for the state of the last add_forces().
  virtual void add_vertex_stress(std::span<VertexStress> out) const = 0;

  /// Energy so far, J: elastic as stored now; dissipated by plasticity and by numerical means (hourglass, bulk
  /// viscosity).
  virtual double elastic_energy() const = 0;
  virtual double plastic_work() const = 0;
  virtual double numerical_work() const = 0;

  /// After an edit of `mesh` (already applied). Positions at rest and those at present, new vertices included.
  virtual void update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> present,
                      const ElementHeritage& heritage) = 0;

  /// All that changes from step to step; read back into an object made for the same mesh as was written.
  virtual void archive(Archive& archive) = 0;
};

}  // namespace volccd::simulation
