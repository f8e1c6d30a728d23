// Small models for tests of the time loop.
#pragma once

#include <cmath>
#include <initializer_list>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/simulation/simulation.hpp>

namespace volccd::simulation {

inline Material soft() {
  Material m;
  m.density = 1000;
  m.youngs_modulus = 1e6;
  m.poisson_ratio = 0.3;
  return m;
}

struct BlockSpec {
  ElementType type = ElementType::hexahedron;
  int nx = 2, ny = 2, nz = 2;
  Vec3 size = Vec3(0.1, 0.1, 0.1);  ///< of a cell
  Vec3 at = Vec3::Zero();           ///< lowest corner
  Vec3 velocity = Vec3::Zero();
  Body body = {"block", soft()};
};

/// Makes each block a body of its own.
inline Model blocks(std::initializer_list<BlockSpec> specs) {
  Shape all;
  Model model;
  for (const BlockSpec& spec : specs) {
    Shape shape = block(spec.type, spec.nx, spec.ny, spec.nz);
    for (Vec3& x : shape.positions) x = x.cwiseProduct(spec.size) + spec.at;
    model.velocities.insert(model.velocities.end(), shape.positions.size(), spec.velocity);
    all.append(shape, static_cast<std::int32_t>(model.bodies.size()));
    model.bodies.push_back(spec.body);
  }
  model.mesh = all.mesh();
  model.positions = all.positions;
  return model;
}

/// Checks mass, momentum without external impulses, and energy up to this fraction.
inline void expect_kept(const Ledger& before, const Ledger& after, double energy) {
  EXPECT_NEAR(after.mass, before.mass, 1e-13 * before.mass);
  EXPECT_LT((after.momentum - before.momentum - after.impulse).norm(), 1e-10 * before.momentum.norm());
  EXPECT_LT(std::abs(after.balance_error()), energy * before.initial);
}

/// Mean of the positions (or velocities) of a body's vertices.
inline Vec3 mean(const Simulation& s, std::span<const Vec3> values, std::int32_t body) {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  const Mesh& mesh = s.topology().mesh();
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && mesh.object(o) == body)
      for (Index v : mesh.vertices(o)) {
        sum += values[v];
        ++count;
      }
  return sum / count;
}

}  // namespace volccd::simulation
