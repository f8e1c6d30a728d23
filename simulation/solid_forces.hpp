// Internal forces of solids: tetrahedra of constant strain, hexahedra integrated at one point with hourglass control,
// and their halves.
#pragma once

#include <memory>

#include <volccd/simulation/element_forces.hpp>

namespace volccd::simulation {

/// Both elements are total-Lagrangian: the mean deformation gradient F is linear in the positions, with the gradients
/// of the shape at rest (Flanagan and Belytschko 1981: the mean over the element, so that patch tests are exact). No
/// step divides by the present volume unless it is well above zero, so that flat and inverted elements get finite
/// forces that restore them; nothing has to be integrated in a rotating frame, so that rotations are exact, and an
/// element that is split off or cut keeps its stress by keeping its state.
///
/// Elastic part: neo-Hookean in the form of Smith, de Goes and Kim 2018, per volume at rest
///     W = mu/2 (tr be - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2,   be = F Cp^-1 F^T, J = det F,
/// Hooke's law with Lame's lambda and mu for small strains, finite and smooth for every F.
/// Plastic part: multiplicative J2, radial return on the deviator of be (Simo 1988; no eigenvectors), volume kept
/// exactly. Flow stops in an element that has become ten times thinner than at rest, or is compressed to a tenth of its
/// volume: it is elastic from there on, so that the stable step stays bounded from below.
///
/// Hourglass modes of a hexahedron have a spring each, as stiff as the bending that they stand for; it yields with the
/// material (then the shape at rest changes). The spring's energy counts as elastic, what it loses by yielding as
/// numerical. Bulk viscosity in compression: linear 0.06, quadratic 1.2 (squared), against ringing behind shocks.
///
/// stable_step() bounds the greatest frequency of each element by itself, so that elements that came loose are stable
/// too; for a cube it is edge sqrt(density / 3K), K the bulk modulus, less an eighth for viscosity.
///
/// Edits: an element that is its parent's only child and of its type keeps the parent's shape at rest, corner by corner
/// (vertices were split or merged); pieces of a tetrahedron have the shapes that the reference positions give, and of
/// their parent's state all but the flow of hourglass modes. One with no volume at rest is left without force and mass.
///
/// Wedges are what a hexahedron breaks into (element_breaking.hpp), and no model begins with one. A wedge is integrated
/// as a hexahedron of which two edges have no length, with the two hourglass modes that this leaves. Its shape at rest
/// is what its parent's deformation makes its present shape of, so that the stress stays; its mass is half the parent's
/// and lies so at its vertices that each keeps what it had: the second of each triangle has twice the others' share.
///
/// Throws InputError for solids of other types, no volume at rest, a part that is not there, a material that makes no
/// sense. add_forces throws Error when an element's deformation is not finite. It allocates nothing but after an edit.
std::unique_ptr<ElementForces> make_solid_forces(const Model& model);

}  // namespace volccd::simulation
