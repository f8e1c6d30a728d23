// Internal forces of solids: tetrahedra of constant strain, hexahedra integrated at one point with hourglass control,
// and wedges that are halves of hexahedra.
#pragma once

#include <memory>

#include <volccd/simulation/elements/element_forces.hpp>

namespace volccd::simulation {

/// Both elements are total-Lagrangian: the mean deformation gradient F is linear in the positions, with the gradients
/// of the shape at rest (Flanagan and Belytschko 1981: the mean over the element, so that patch tests are exact). No
/// operation divides by the present volume unless it is well above zero, so that flat and inverted elements get finite
/// forces that restore them. Nothing is integrated in a rotating frame, so that rotations are exact. An element that is
/// split off or cut keeps its stress because it keeps its state.
///
/// Elastic part: neo-Hookean in the form of Smith, de Goes and Kim 2018, with the energy per volume at rest
///     W = mu/2 (tr be - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2,   be = F Cp^-1 F^T, J = det F,
/// Hooke's law with Lame's lambda and mu for small strains, finite and smooth for every F.
/// Plastic part: multiplicative J2, radial return on the deviator of be (Simo 1988; no eigenvectors), volume kept
/// exactly. Flow stops in an element that is ten times thinner than at rest, or compressed to a tenth of its volume. It
/// is elastic beyond that, so that the stable step is bounded from below.
///
/// Each hourglass mode of a hexahedron has a spring with the stiffness of the bending mode that it represents; the
/// spring yields with the material, which changes the shape at rest. The energy of the spring counts as elastic, and
/// its loss by yielding as numerical. Bulk viscosity in compression (linear 0.06, quadratic 1.2 squared) damps
/// oscillations behind shocks.
///
/// stable_step() bounds the greatest frequency of each element separately, so that it is also valid for elements that
/// have become detached. For a cube it is edge sqrt(density / 3K), where K is the bulk modulus, less an eighth for
/// viscosity. It is smaller where an element would deform by more than a tenth in a step at the present velocities,
/// because the frequency grows as the element gets thinner.
///
/// Edits: an element that is its parent's only child, and of the same type, keeps the parent's shape at rest, corner by
/// corner (vertices were split or merged). Pieces of a tetrahedron have the shapes that the reference positions give,
/// and inherit their parent's state. An element without volume at rest has neither forces nor mass.
///
/// Wedges arise only when a hexahedron breaks (element_breaking.hpp); a model cannot contain them. A wedge is
/// integrated as a hexahedron in which two edges have length zero, with the two remaining hourglass modes. Its shape at
/// rest is the one that its parent's deformation maps to its present shape, so that the stress does not change. Its
/// mass is half the parent's, distributed so that the mass of each vertex does not change: the second vertex of each
/// triangle has twice the share of the others.
///
/// Throws InputError for solids of other types, elements without volume at rest, a missing body, and an invalid
/// material. add_forces throws Error when an element's deformation is not finite. It allocates memory only after an
/// edit.
std::unique_ptr<ElementForces> make_solid_forces(const Model& model);

}  // namespace volccd::simulation
