// Four solid elements side by side: what the vector kernel takes and gives.
#pragma once

#include <volccd/simulation/detail/solid_element.hpp>

namespace volccd::simulation::detail {

inline constexpr int kSolidLanes = 4;

/// Below this J nothing is divided by J and nothing flows.
inline constexpr double kFlat = 0.1;

using SolidLane = double[kSolidLanes];

/// One number of each element at a time. Lanes from `count` on repeat an element, and give nothing.
template <int N>
struct alignas(32) SolidBatch {
  SolidLane x[N][3], v[N][3];  ///< from the first corner on, whose own are not read
  SolidLane gradients[N][3], volume, spread[6], greatest_spread;
  SolidLane mu, dilation, density, sound, young, yield;  ///< yield stress at rate 0, as strained so far
  SolidLane metric[6];
  SolidLane mode_slopes[mode_count(N) + 1], modes[mode_count(N) + 1][3];

  SolidLane f[3][3], cofactor[3][3], j, volume_rate;
  SolidLane deviator[6], norm2, mean;                             ///< of be; squared norm of the deviator
  SolidLane scale, new_mean;                                      ///< plastic flow: of the deviator; the mean after it
  SolidLane q[mode_count(N) + 1][3], q_norm2[mode_count(N) + 1];  ///< hourglass modes

  SolidLane force[N][3], energy, viscous_pressure, step;  ///< step: not above 0 if the deformation is not finite

  const SolidShape<N>* shapes[kSolidLanes];
  SolidState<N>* states[kSolidLanes];
  const SolidMaterial* materials[kSolidLanes];
  int count = 0;
  bool deformation_given = false;  ///< f is there, and velocities are 0; forces have no meaning
};

/// From x to step. Calls the two below for elements that yield, if dt > 0.
void respond(SolidBatch<4>& batch, double dt);
void respond(SolidBatch<8>& batch, double dt);

/// Plastic flow of an element whose trial stress is beyond yield: advances its state, sets metric, scale and new_mean.
template <int N>
void flow(SolidBatch<N>& batch, int lane, double dt);

/// The same for its hourglass modes: sets modes, q and q_norm2.
void flow_modes(SolidBatch<8>& batch, int lane);

}  // namespace volccd::simulation::detail
