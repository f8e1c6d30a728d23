// Solid elements: shape at rest, state, and forces of a range of elements. N is the number of corners: 4 for a
// tetrahedron, 8 for a hexahedron, or for a wedge, which is a hexahedron with two edges of length zero.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <volccd/simulation/model.hpp>

namespace volccd::simulation::detail {

/// The material of a body, with constants for the kernel.
struct SolidMaterial {
  explicit SolidMaterial(const Body& body);

  Material material;
  double mu, dilation;  ///< shear modulus; lambda + mu
  double sound;         ///< speed of sound
  bool rigid;
};

/// Symmetric 3 x 3: xx, yy, zz, xy, yz, zx.
using Symmetric = Eigen::Matrix<double, 6, 1>;

inline constexpr int mode_count(int corners) { return corners == 8 ? 4 : 0; }

/// An array of zero vectors. Eigen does not initialise vectors, and whole rows are written to checkpoints.
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
  double packing = 1;                               ///< mass / (volume * density of the material)
  Symmetric spread = Symmetric::Zero();             ///< sum of gradient gradient^T
  double greatest_spread = 0;                       ///< its greatest eigenvalue
  std::array<double, mode_count(N)> mode_slopes{};  ///< squared: (strain at the faces / |q|)^2
  std::array<Vec3, mode_count(N)> modes = filled<mode_count(N)>();  ///< a, from the rest positions
  std::array<Index, N> vertices{};
  Index slot = kNone;      ///< of the element; kNone: an empty row
  std::uint32_t body = 0;  ///< object id
};

/// The state of an element, which changes from step to step.
template <int N>
struct SolidState {
  Eigen::Matrix3d deformation = Eigen::Matrix3d::Identity();        ///< F of the last call
  Symmetric plastic_metric = identity();                            ///< Cp^-1
  double plastic_strain = 0;                                        ///< equivalent
  double viscous_pressure = 0;                                      ///< of the last call, Pa
  double energy = 0, plastic_work = 0, numerical_work = 0;          ///< J; energy at the last call, works so far
  std::array<Vec3, mode_count(N)> modes = filled<mode_count(N)>();  ///< a, as hourglass modes flowed

  static Symmetric identity() { return (Symmetric() << 1, 1, 1, 0, 0, 0).finished(); }
};

/// Sets the shape at rest for corners at `x`, except for vertices, slot and body. Returns false, and sets volume 0, if
/// there is no volume. `wedge`: corners 1 and 2 are the same vertex, and so are 5 and 6.
template <int N>
bool set_shape(const std::array<Vec3, N>& x, SolidShape<N>& shape, bool wedge = false);

/// Input and output of solid_forces() for elements of one type, one row for each element.
template <int N>
struct SolidRun {
  std::span<const SolidShape<N>> shapes;
  std::span<SolidState<N>> states;
  std::span<const SolidMaterial> materials;  ///< by body
  std::span<const Vec3> x, v;                ///< by vertex
  double dt;
  Vec3* out;  ///< N forces for each row
};

/// Largest stable step of all elements (infinite if there are none), and the smallest slot of an element whose
/// deformation is not finite.
struct SolidBound {
  double step;
  Index broken = kNone;
};

/// Whether a row has forces: it is not empty, not rigid, and not flat at rest.
template <int N>
bool is_active(const SolidShape<N>& shape, std::span<const SolidMaterial> materials) {
  return shape.slot != kNone && shape.volume > 0 && !materials[shape.body].rigid;
}

/// Computes internal forces of the active rows in [begin, end) and advances their states by `dt` (dt = 0: only
/// deformation, energy and viscous pressure). The results of a row do not depend on other rows.
template <int N>
SolidBound solid_forces(const SolidRun<N>& run, std::size_t begin, std::size_t end);

/// Stable step of one active element at the deformation of its state, without velocity.
template <int N>
double stable_step(const SolidShape<N>& shape, const SolidState<N>& state, std::span<const SolidMaterial> materials);

/// Cauchy stress times present volume for the state of the last call, without hourglass modes and viscosity.
template <int N>
Eigen::Matrix3d stress_times_volume(const SolidShape<N>& shape, const SolidMaterial& material,
                                    const SolidState<N>& state);

}  // namespace volccd::simulation::detail
