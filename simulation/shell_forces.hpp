// Internal forces of thin shells: triangles without rotational degrees of freedom, membrane and bending apart.
#pragma once

#include <memory>

#include <volccd/simulation/element_forces.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

namespace detail {
struct ShellTables;
}

/// Membrane: constant strain, plane stress, any rotation. Elastic law: Hencky's, quadratic in the logarithmic principal
/// strains (neo-Hookean to second order; a pull follows sigma = E ln(stretch) times the reference area), made linear
/// where an elastic stretch leaves [1/5, 5], so that forces stay finite down to zero area. Beyond yield: J2 in plane
/// stress, finite strain, radial return along the principal axes (backward Euler), linear hardening and rate factor by
/// the equivalent plastic strain and its rate.
///
/// Bending: a hinge at each edge between two triangles (discrete shells), stiffness E h^3 / (12 (1 - nu^2)) times
/// length^2 / (sum of areas), which gives a cylinder its plate energy on meshes of equilateral triangles (any
/// direction) and of rectangles cut in two (along their sides). Hinges do not see Poisson's ratio: equilateral
/// triangles bend as a plate of ratio -1/3, so that a free strip is 2 % too soft for steel; on squares cut in two it is
/// 19 % too soft, and twist along the sides too stiff. Rest angles are those of the reference positions. Beyond yield
/// the rest angle flows at the fully plastic moment Y h^2 / 4 a length, Y with hardening by the mean strain over the
/// thickness and with the rate factor. Bending and membrane yield independently. Where n triangles meet at an edge,
/// each pair has a hinge, so stiff that the edge acts as a rigid joint; a rigid part's triangle clamps its neighbours'
/// edge.
///
/// Damping: viscosity proportional to stiffness, 5 % of critical at each element's highest frequency, less below.
///
/// A triangle without area at rest has neither mass nor forces. Plastic flow stops in one drawn out or squashed
/// tenfold. One squashed below a fifth of its height (beyond its flow) no longer bends the more for it nor shortens the
/// step. Finite input makes no NaN; what is not finite, or overflows, makes add_forces throw Error.
class ShellForces final : public ElementForces {
 public:
  /// Model::positions are the rest shape. Throws InputError: quads, positions that are not finite, a part with shells
  /// whose thickness or material is not possible. O(n log n).
  explicit ShellForces(const Model& model);
  ~ShellForces() override;

  void add_masses(std::span<double> mass) const override;
  /// No allocation once it has run with as many workers.
  void add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                  std::span<Vec3> force) override;
  double stable_step() const override;
  /// Of the membrane, at mid-surface: neither bending nor viscosity.
  void add_vertex_stress(std::span<VertexStress> out) const override;
  double elastic_energy() const override;
  double plastic_work() const override;
  double numerical_work() const override;
  /// Sorts anew, O(shells log shells); stable_step() and the energies stay those of the last add_forces(). An element
  /// with a parent takes over its plastic strain and the hinges that the parent had; it must be numbered in the
  /// parent's sense of rotation.
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
