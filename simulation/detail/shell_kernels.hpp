// Forces of one block of shells, vectorised: the same bits for every instruction set.
#pragma once

#include <volccd/simulation/detail/shell_tables.hpp>

namespace volccd::simulation::detail {

/// `copy`: the block's vertices, kCopyStride doubles each: position, velocity. Adds to `forces`, kForceStride doubles a
/// vertex. Advances the state if dt > 0. Throws Error when a deformation is not finite.
void add_block_forces(ShellTables& tables, std::size_t block, const double* copy, double dt, double* forces);

/// What a vector of lanes leaves to scalar code. Lanes in order, one value each.
struct MembraneLanes {
  double squared_stretch[2][kShellPadding];
  double mean[kShellPadding], difference[kShellPadding], shear[kShellPadding], radius[kShellPadding];
  double stress[2][kShellPadding];
  double energy[kShellPadding];  ///< a volume
};
/// Lane `lane` is triangle `triangle`: yields, or is stretched far. Returns its plastic work.
double exceptional_membrane(ShellTables& tables, const ShellLaw& law, std::size_t triangle, double dt,
                            MembraneLanes& lanes, std::size_t lane);
/// Hinge whose trial moment exceeds its capacity: flows. `moment` in and out, with its sign. Returns the plastic work.
double exceptional_hinge(ShellTables& tables, std::size_t hinge, double dt, double& moment);

}  // namespace volccd::simulation::detail
