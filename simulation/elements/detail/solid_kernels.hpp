// Input and output of the vector kernel, which processes four solid elements at once.
#pragma once

#include <volccd/simulation/elements/detail/solid_element.hpp>

namespace volccd::simulation::detail {

inline constexpr int kSolidLanes = 4;

/// Below this J, the kernel does not divide by J, and there is no plastic flow.
inline constexpr double kFlat = 0.1;

/// By how much an element may deform in a stable step. (The bound of the frequency is that of the present shape.)
inline constexpr double kStrainPerStep = 0.1;

using SolidLane = double[kSolidLanes];

/// A SolidLane has one value for each of the four elements. Lanes from `count` on repeat an element, and their results
/// are unused.
template <int N>
struct alignas(32) SolidBatch {
  SolidLane x[N][3], v[N][3];  ///< relative to the first corner, whose entries are not read
  SolidLane gradients[N][3], volume, spread[6], greatest_spread;
  SolidLane mu, dilation, density, sound, young, yield;  ///< yield stress at rate 0 and the present strain
  SolidLane metric[6];
  SolidLane mode_slopes[mode_count(N) + 1], modes[mode_count(N) + 1][3];

  SolidLane f[3][3], cofactor[3][3], j, volume_rate;
  SolidLane deviator[6], norm2, mean;                             ///< of be; squared norm of the deviator
  SolidLane scale, new_mean;                                      ///< after plastic flow: factor of the deviator; mean
  SolidLane q[mode_count(N) + 1][3], q_norm2[mode_count(N) + 1];  ///< hourglass modes

  SolidLane force[N][3], energy, viscous_pressure, step;  ///< step: not above 0 if the deformation is not finite

  const SolidShape<N>* shapes[kSolidLanes];
  SolidState<N>* states[kSolidLanes];
  const SolidMaterial* materials[kSolidLanes];
  int count = 0;
  bool deformation_given = false;  ///< f is an input, velocities are 0; forces are undefined
};

/// Computes all members from x to step. Calls the two functions below for elements that yield, if dt > 0.
void respond(SolidBatch<4>& batch, double dt);
void respond(SolidBatch<8>& batch, double dt);

/// Plastic flow of an element whose trial stress is beyond yield: advances its state, sets metric, scale and new_mean.
template <int N>
void flow(SolidBatch<N>& batch, int lane, double dt);

/// Plastic flow of the hourglass modes of an element: sets modes, q and q_norm2.
void flow_modes(SolidBatch<8>& batch, int lane);

}  // namespace volccd::simulation::detail
