// Forces of one solid element. N corners: 4, a tetrahedron; 8, a hexahedron.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include <volccd/experiments/simulation/model.hpp>

namespace volccd::simulation::detail {

/// A part's material, as the kernel wants it.
struct SolidMaterial {
  explicit SolidMaterial(const Part& part);

  Material material;
  double mu, dilation;  ///< shear modulus; lambda + mu
  double sound;         ///< speed of
  bool plastic, rigid;
};

/// Symmetric 3 x 3: xx, yy, zz, xy, yz, zx.
using Symmetric = Eigen::Matrix<double, 6, 1>;

inline constexpr int mode_count(int corners) { return corners == 8 ? 4 : 0; }

/// Zeros: Eigen leaves vectors as they are, and rows go to checkpoints whole.
template <int Count>
std::array<Vec3, Count> filled() {
  std::array<Vec3, Count> zeros;
  zeros.fill(Vec3::Zero());
  return zeros;
}

/// An element at rest. Hourglass modes q = (1/8) sum h x - F a are 0 in any affine deformation.
template <int N>
struct SolidShape {
  std::array<Vec3, N> gradients = filled<N>();      ///< mean over the element of each corner's shape function
  double volume = 0;                                ///< 0: neither force nor mass
  Symmetric spread = Symmetric::Zero();             ///< sum of gradient gradient^T
  double greatest_spread = 0;                       ///< its greatest eigenvalue
  std::array<double, mode_count(N)> mode_slopes{};  ///< squared slope along which mode q bends: strain = slope |q|
  std::array<Vec3, mode_count(N)> modes = filled<mode_count(N)>();  ///< a, from the rest positions
  std::array<Index, N> vertices;
  Index slot = kNone;      ///< of the element; kNone: an empty row
  std::uint32_t part = 0;  ///< object id
};

/// What changes from step to step.
template <int N>
struct SolidState {
  Eigen::Matrix3d deformation = Eigen::Matrix3d::Identity();  ///< F of the last call
  Symmetric plastic_metric = identity();                      ///< Cp^-1
  double plastic_strain = 0;                                  ///< equivalent
  double energy = 0, plastic_work = 0, numerical_work = 0;    ///< J; the first as of the last call, the others so far
  std::array<Vec3, mode_count(N)> modes = filled<mode_count(N)>();  ///< a, as hourglass modes flowed

  static Symmetric identity() { return (Symmetric() << 1, 1, 1, 0, 0, 0).finished(); }
};

/// Shape at rest for corners at `x`: all but vertices, slot and part. False, with volume 0, if there is no volume.
template <int N>
bool set_shape(const std::array<Vec3, N>& x, SolidShape<N>& shape);

/// Internal forces at positions `x` to `out[corner]`, and the state advanced by `dt` (0: the deformation and the energy
/// only). Returns the largest stable step of the element by itself; not above zero if its deformation is not finite.
template <int N>
double solid_forces(const SolidShape<N>& shape, const SolidMaterial& material, std::span<const Vec3> x,
                    std::span<const Vec3> v, double dt, SolidState<N>& state, Vec3* out);

/// As solid_forces() returns it, for the state of the last call and no velocity.
template <int N>
double stable_step(const SolidShape<N>& shape, const SolidMaterial& material, const SolidState<N>& state);

/// Cauchy stress times present volume, for the state of the last call; hourglass modes and viscosity left out.
template <int N>
Eigen::Matrix3d stress_times_volume(const SolidShape<N>& shape, const SolidMaterial& material,
                                    const SolidState<N>& state);

}  // namespace volccd::simulation::detail
