// Interface between the time loop and the internal forces of one family of elements (solids or shells).
#pragma once

#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// Element slots that a topology edit has removed and added. A slot may be in both lists.
struct ElementHeritage {
  std::vector<Index> removed;
  std::vector<Index> added;
  /// For each of `added`: the slot, before the edit, of the element whose state it inherits (history, and the reference
  /// shape as far as the reference positions do not give it).
  std::vector<Index> parents;
};

/// Input of the failure criterion at one vertex: sums over the elements at it, weighted by volume.
struct VertexStress {
  Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();  ///< Cauchy, times volume
  double plastic_strain = 0;                         ///< equivalent, times volume
  double volume = 0;
};

/// Computes the forces of the elements of its family in the mesh, except for those of rigid bodies, and ignores other
/// elements. Not thread-safe.
class ElementForces {
 public:
  virtual ~ElementForces() = default;

  /// Adds the lumped masses of ALL elements of the family, those of rigid bodies included.
  virtual void add_masses(std::span<double> mass) const = 0;

  /// Adds internal forces at positions `x`, and advances plasticity by the step that led there, of length `dt` with
  /// velocities `v` (dt = 0: plasticity does not advance). Bit for bit the same for any number of threads.
  virtual void add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                          std::span<Vec3> force) = 0;

  /// Largest stable time step (Courant condition, least over the elements, without a safety factor), for the shapes of
  /// the last add_forces().
  virtual double stable_step() const = 0;

  /// Adds the stresses of the last add_forces() to `out` (by vertex).
  virtual void add_vertex_stress(std::span<VertexStress> out) const = 0;

  /// Energies in J: the elastic energy stored now, and the energy dissipated so far by plasticity and by numerical
  /// damping (hourglass control, bulk viscosity).
  virtual double elastic_energy() const = 0;
  virtual double plastic_work() const = 0;
  virtual double numerical_work() const = 0;

  /// To be called after an edit has been applied to `mesh`. `reference` and `present`: positions at rest and now, new
  /// vertices included.
  virtual void update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> present,
                      const ElementHeritage& heritage) = 0;

  /// Writes or reads all state that changes from step to step. State must be read into an object made for the same
  /// mesh.
  virtual void archive(Archive& archive) = 0;
};

}  // namespace volccd::simulation
