// Sheets of triangles, and a time loop without contacts, for the tests of shells.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/executor.hpp>
#include <volccd/core/random.hpp>
#include <volccd/simulation/elements/shell_forces.hpp>

namespace volccd::simulation::shell_test {

inline Material steel() {
  Material m;
  m.density = 7800;
  m.youngs_modulus = 2e11;
  m.poisson_ratio = 0.3;
  return m;
}

inline Material yielding_steel() {
  Material m = steel();
  m.yield_stress = 3e8;
  m.hardening_modulus = 1e9;
  return m;
}

inline Model one_part(const Material& material, double thickness) {
  Model model;
  Body body;
  body.name = "sheet";
  body.material = material;
  body.thickness = thickness;
  model.bodies.push_back(body);
  return model;
}

inline void add_vertices(Model& model, const std::vector<Vec3>& positions) {
  model.mesh.add_vertices(static_cast<Index>(positions.size()));
  model.positions.insert(model.positions.end(), positions.begin(), positions.end());
  model.velocities.resize(model.positions.size(), Vec3::Zero());
}

inline Index add_triangle(Model& model, Index a, Index b, Index c, std::int32_t object = 0) {
  const std::int64_t id = model.mesh.element_slots();
  return model.mesh.add_element({.type = ElementType::triangle, .vertices = {a, b, c}, .object = object, .id = id});
}

/// nx by ny rectangles of size a by b in the plane z = 0, each divided into two triangles by alternating diagonals.
/// `jitter` moves interior vertices in the plane by this fraction of the size; every third triangle is then numbered in
/// the opposite sense.
inline Model sheet(Index nx, Index ny, double a, double b, const Material& material, double thickness,
                   double jitter = 0) {
  Model model = one_part(material, thickness);
  Random random(7);
  std::vector<Vec3> positions;
  for (Index j = 0; j <= ny; ++j) {
    for (Index i = 0; i <= nx; ++i) {
      const bool inside = i > 0 && j > 0 && i < nx && j < ny;
      const double dx = random.uniform(-jitter, jitter), dy = random.uniform(-jitter, jitter);
      positions.push_back({a * (i + (inside ? dx : 0)), b * (j + (inside ? dy : 0)), 0});
    }
  }
  add_vertices(model, positions);
  Index count = 0;
  const auto add = [&](Index p, Index q, Index r) {
    if (jitter > 0 && ++count % 3 == 0) std::swap(q, r);
    add_triangle(model, p, q, r);
  };
  for (Index j = 0; j < ny; ++j) {
    for (Index i = 0; i < nx; ++i) {
      const Index p = j * (nx + 1) + i, q = p + 1, r = p + nx + 2, s = p + nx + 1;
      if ((i + j) % 2 == 0) {
        add(p, q, r);
        add(p, r, s);
      } else {
        add(p, q, s);
        add(q, r, s);
      }
    }
  }
  return model;
}

/// Three sheets of one triangle each with a common edge, numbered in different senses, and folded at rest.
inline Model joint(const Material& material, double thickness) {
  Model model = one_part(material, thickness);
  add_vertices(model, {{0, 0, 0}, {0, 1, 0}, {1, 0.4, 0}, {-0.9, 0.5, 0.3}, {0.1, 0.6, 1.1}});
  add_triangle(model, 0, 1, 2);
  add_triangle(model, 0, 1, 3);
  add_triangle(model, 4, 1, 0);
  return model;
}

class Loop {
 public:
  explicit Loop(Model m)
      : model(std::move(m)),
        shells(std::make_unique<ShellForces>(model)),
        x(model.positions),
        v(x.size(), Vec3::Zero()),
        force(x.size(), Vec3::Zero()),
        mass(x.size(), 0),
        held(x.size(), false) {
    shells->add_masses(mass);
  }

  void compute(double dt) {
    force.assign(x.size(), Vec3::Zero());
    SerialExecutor serial;
    shells->add_forces(x, v, dt, serial, force);
  }

  /// Leapfrog integration. `load` is added to the internal forces; `damping` is proportional to mass.
  void run(int steps, double dt, const std::function<void(std::vector<Vec3>&)>& load = {}, double damping = 0) {
    for (int k = 0; k < steps; ++k) {
      if (load) load(force);
      for (std::size_t i = 0; i < x.size(); ++i) {
        if (held[i] || mass[i] == 0) continue;
        v[i] = v[i] * (1 - damping * dt) + force[i] * (dt / mass[i]);
        x[i] += dt * v[i];
      }
      compute(dt);
    }
  }

  double kinetic_energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += 0.5 * mass[i] * v[i].squaredNorm();
    return sum;
  }

  std::vector<VertexStress> stress() const {
    std::vector<VertexStress> out(x.size());
    shells->add_vertex_stress(out);
    return out;
  }

  double greatest_force() const {
    double max = 0;
    for (const Vec3& f : force) max = std::max(max, f.norm());
    return max;
  }

  Model model;
  std::unique_ptr<ShellForces> shells;
  std::vector<Vec3> x, v, force;
  std::vector<double> mass;
  std::vector<bool> held;
};

inline Vec3 random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

inline Eigen::Matrix3d some_rotation() {
  return Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
}

}  // namespace volccd::simulation::shell_test
