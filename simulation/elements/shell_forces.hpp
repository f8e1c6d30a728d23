// Internal forces of thin shells: triangles without rotational degrees of freedom, with separate membrane and bending.
#pragma once

#include <memory>

#include <volccd/simulation/elements/element_forces.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

namespace detail {
struct ShellTables;
}

/// Membrane: constant strain and plane stress, for arbitrary rotations. The elastic law is Hencky's: the energy is
/// quadratic in the logarithmic principal strains (neo-Hookean to second order; in uniaxial tension the force is E
/// ln(stretch) times the reference area). It is extrapolated linearly if an elastic stretch leaves [1/5, 5], so that
/// forces stay finite down to zero area. Beyond yield: J2 plasticity in plane stress at finite strain, with radial
/// return along the principal axes (backward Euler), linear hardening, and a rate factor from the equivalent plastic
/// strain and its rate.
///
/// Bending: a hinge at each edge between two triangles (discrete shells), stiffness E h^3 / (12 (1 - nu^2)) times
/// length^2 / (sum of areas), which gives a cylinder its plate energy on meshes of equilateral triangles (any
/// direction) and of rectangles cut in two (along their sides). Hinges do not see Poisson's ratio: equilateral
/// triangles bend as a plate of ratio -1/3, so that a free strip is 2 % too soft for steel; on squares cut in two it is
/// 19 % too soft, and twist along the sides too stiff. Rest angles are those of the reference positions. Beyond yield
/// the rest angle flows at the fully plastic moment Y h^2 / 4 a length, where Y hardens with the mean strain over the
/// thickness and with the rate factor. Bending and membrane yield independently. If n > 2 triangles meet at an edge,
/// each pair has a hinge, which is so stiff that the edge acts as a rigid joint; a triangle of a rigid body clamps the
/// edges of its neighbours.
///
/// Damping: viscosity proportional to stiffness, 5 % of critical damping at each element's highest frequency, and less
/// at lower ones.
///
/// A triangle without area at rest has neither mass nor forces. Plastic flow stops in a triangle that is stretched or
/// compressed tenfold. If a triangle is elastically compressed below a fifth of its height, its bending forces do not
/// grow further and the stable step does not decrease further. Finite input does not produce NaN; add_forces throws
/// Error for values that are not finite or overflow.
class ShellForces final : public ElementForces {
 public:
  /// Model::positions are the rest shape. Throws InputError for quads, for positions that are not finite, and for a
  /// body with shells whose thickness or material is invalid. O(n log n).
  explicit ShellForces(const Model& model);
  ~ShellForces() override;

  void add_masses(std::span<double> mass) const override;
  /// Does not allocate after the first call with the same number of workers.
  void add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                  std::span<Vec3> force) override;
  double stable_step() const override;
  /// Stress of the membrane at the mid-surface, without bending and viscosity.
  void add_vertex_stress(std::span<VertexStress> out) const override;
  double elastic_energy() const override;
  double plastic_work() const override;
  double numerical_work() const override;
  /// Sorts all shells again, O(shells log shells); stable_step() and the energies remain those of the last
  /// add_forces(). An element with a parent inherits the plastic strain and the hinges of the parent; its node order
  /// must have the same orientation as the parent's.
  void update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> present,
              const ElementHeritage& heritage) override;
  void archive(Archive& archive) override;

  std::size_t triangle_count() const;  ///< those that deform
  std::size_t hinge_count() const;

 private:
  std::unique_ptr<detail::ShellTables> tables_;
};

std::unique_ptr<ElementForces> make_shell_forces(const Model& model);

}  // namespace volccd::simulation
