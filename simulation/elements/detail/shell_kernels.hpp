// Forces of one block of shells, vectorised: the same bits for every instruction set.
#pragma once

#include <volccd/simulation/elements/detail/shell_tables.hpp>

namespace volccd::simulation::detail {

/// Adds the forces of a block to `forces` (kForceStride doubles for each vertex), and advances the state if dt > 0.
/// `copy`: position and velocity of the block's vertices, kCopyStride doubles for each. Throws Error when a deformation
/// is not finite.
void add_block_forces(ShellTables& tables, std::size_t block, const double* copy, double dt, double* forces);

/// Values of one vector of triangles that scalar code completes; one value for each lane.
struct MembraneLanes {
  double squared_stretch[2][kShellPadding];
  double mean[kShellPadding], difference[kShellPadding], shear[kShellPadding], radius[kShellPadding];
  double stress[2][kShellPadding];
  double energy[kShellPadding];  ///< per volume
};
/// Computes lane `lane`, which is triangle `triangle`, if it yields or is stretched far. Returns its plastic work.
double exceptional_membrane(ShellTables& tables, const ShellLaw& law, std::size_t triangle, double dt,
                            MembraneLanes& lanes, std::size_t lane);
/// Plastic flow of a hinge whose trial moment exceeds its capacity. `moment`: the trial moment, replaced by the final
/// one, with its sign. Returns the plastic work.
double exceptional_hinge(ShellTables& tables, std::size_t hinge, double dt, double& moment);

}  // namespace volccd::simulation::detail
