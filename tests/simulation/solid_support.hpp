// Blocks of solids, and a simple explicit loop, for the tests of the internal forces.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <volccd/core/executor.hpp>
#include <volccd/core/random.hpp>
#include <volccd/simulation/elements/element_forces.hpp>
#include <volccd/simulation/elements/solid_forces.hpp>

namespace volccd::simulation::test {

/// A number in [-1, 1] that depends on the arguments only.
inline double noise(std::uint64_t a, std::uint64_t b) {
  return static_cast<double>(hash_ids(a, b) >> 11) * 0x1p-52 - 1;
}
inline Vec3 noise3(std::uint64_t a, std::uint64_t b) {
  return {noise(a, 3 * b), noise(a, 3 * b + 1), noise(a, 3 * b + 2)};
}

inline Material soft() {
  Material m;
  m.density = 1000, m.youngs_modulus = 1e6, m.poisson_ratio = 0.3;
  return m;
}
inline Material steel() {
  Material m;
  m.density = 7800, m.youngs_modulus = 2e11, m.poisson_ratio = 0.3;
  m.yield_stress = 4e8, m.hardening_modulus = 1e9;
  return m;
}

enum class Solid { tetrahedra, hexahedra, both };

/// n[0] x n[1] x n[2] cubes with edge length `h`, the first at the origin. Each is a hexahedron or six tetrahedra
/// (`both`: alternating along x). Interior vertices are moved by up to `jitter` edges along each axis.
inline Model block(Solid solid, std::array<int, 3> n, double h, const Material& material, double jitter = 0) {
  Model model;
  model.bodies.push_back({"block", material, 0, false});
  const auto at = [&](int i, int j, int k) { return static_cast<Index>((k * (n[1] + 1) + j) * (n[0] + 1) + i); };
  model.mesh.add_vertices(static_cast<Index>((n[0] + 1) * (n[1] + 1) * (n[2] + 1)));
  for (int k = 0; k <= n[2]; ++k) {
    for (int j = 0; j <= n[1]; ++j) {
      for (int i = 0; i <= n[0]; ++i) {
        const bool inside = i > 0 && j > 0 && k > 0 && i < n[0] && j < n[1] && k < n[2];
        model.positions.push_back(h * (Vec3(i, j, k) + (inside ? jitter : 0) * noise3(7, at(i, j, k))));
      }
    }
  }
  model.velocities.assign(model.positions.size(), Vec3::Zero());
  constexpr int kTets[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  std::int64_t id = 0;
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        const std::array<Index, 8> c{
            at(i, j, k),     at(i + 1, j, k),     at(i + 1, j + 1, k),     at(i, j + 1, k),
            at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)};
        if (solid == Solid::hexahedra || (solid == Solid::both && i % 2 == 0)) {
          model.mesh.add_element({.type = ElementType::hexahedron, .vertices = {c.begin(), c.end()}, .id = id++});
          continue;
        }
        for (const auto& t : kTets) {
          model.mesh.add_element(
              {.type = ElementType::tetrahedron, .vertices = {c[t[0]], c[t[1]], c[t[2]], c[t[3]]}, .id = id++});
        }
      }
    }
  }
  return model;
}

/// The forces of a model, and a leapfrog loop.
struct Loop {
  explicit Loop(Model m)
      : model(std::move(m)),
        forces(make_solid_forces(model)),
        x(model.positions),
        v(model.velocities),
        force(x.size()),
        mass(x.size(), 0.0) {
    forces->add_masses(mass);
  }

  void compute(double dt) {
    for (Vec3& f : force) f.setZero();
    forces->add_forces(x, v, dt, executor, force);
  }
  /// A step: v += dt (force / mass), then `hold(v)`, x += dt v, forces.
  template <typename Hold>
  void step(double dt, Hold hold) {
    for (std::size_t i = 0; i < x.size(); ++i) v[i] += dt / mass[i] * force[i];
    hold(v);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += dt * v[i];
    compute(dt);
  }
  void step(double dt) {
    step(dt, [](std::vector<Vec3>&) {});
  }
  double kinetic() const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += 0.5 * mass[i] * v[i].squaredNorm();
    return sum;
  }
  std::vector<VertexStress> stress() const {
    std::vector<VertexStress> s(x.size());
    forces->add_vertex_stress(s);
    return s;
  }
  Eigen::Matrix3d mean_stress() const {
    VertexStress sum;
    for (const VertexStress& s : stress()) sum.stress += s.stress, sum.volume += s.volume;
    return sum.stress / sum.volume;
  }

  Model model;
  std::unique_ptr<ElementForces> forces;
  std::vector<Vec3> x, v, force;
  std::vector<double> mass;
  SerialExecutor executor;
};

inline double largest(const std::vector<Vec3>& values) {
  double m = 0;
  for (const Vec3& a : values) m = std::max(m, a.cwiseAbs().maxCoeff());
  return m;
}

}  // namespace volccd::simulation::test
