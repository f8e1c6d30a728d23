// Deformed blocks of solids, and checks of their forces, for the tests of forces with and without edits.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/simulation/elements/material.hpp>

#include "solid_support.hpp"

namespace volccd::simulation::test {

inline const Eigen::Matrix3d kStretch =
    (Eigen::Matrix3d() << 1.3, 0.2, -0.1, 0.05, 0.8, 0.15, 0.1, -0.2, 1.1).finished();

/// A block of 4 x 4 x 4 soft cells of size 0.1 with a shape at rest and the affine deformation kStretch has forces on
/// its boundary only, and no energy in hourglass springs.
inline void expect_patch(Loop& loop) {
  const Eigen::Matrix3d& f = kStretch;
  for (Vec3& x : loop.x) x = f * x + Vec3(5, -3, 2);
  loop.compute(0);
  double boundary = 0, inside = 0;
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    const Vec3 rest = loop.model.positions[i];
    const bool in = rest.minCoeff() > 0.01 && rest.maxCoeff() < 0.39;
    (in ? inside : boundary) = std::max(in ? inside : boundary, loop.force[i].norm());
  }
  EXPECT_GT(boundary, 100);
  EXPECT_LT(inside, 1e-11 * boundary);
  const double mu = shear_modulus(soft()), lambda = lame_lambda(soft()), j = f.determinant();
  const double w = mu / 2 * (f.squaredNorm() - 3) - mu * (j - 1) + (lambda + mu) / 2 * (j - 1) * (j - 1);
  EXPECT_NEAR(loop.forces->elastic_energy(), 0.064 * w, 1e-10 * w);
}

/// Deformed positions with random displacements of up to `shake` edges.
inline void shake(Loop& loop, double edge, double amount, std::uint64_t seed) {
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    loop.x[i] = kStretch * loop.model.positions[i] + amount * edge * noise3(seed, i);
    loop.v[i] = 100 * noise3(seed + 1000, i);
  }
}

/// Compares central differences of the stored energy with the force in random directions: in the elastic range, and
/// elastically about a state with plastic flow.
inline void expect_force_of_energy(Loop& loop, double edge, std::uint64_t seed) {
  for (Vec3& v : loop.v) v.setZero();
  loop.compute(0);
  const std::vector<Vec3> x = loop.x, force = loop.force;
  for (std::uint64_t k = 0; k < 5; ++k) {
    const double e = 1e-5 * edge;
    double power = 0, size = 0, energy[2];
    for (int s = 0; s < 2; ++s) {
      for (std::size_t i = 0; i < x.size(); ++i) loop.x[i] = x[i] + (s == 0 ? -e : e) * noise3(seed + k, i);
      loop.compute(0);
      energy[s] = loop.forces->elastic_energy();
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      power += force[i].dot(noise3(seed + k, i));
      size += force[i].norm();
    }
    EXPECT_NEAR((energy[1] - energy[0]) / (2 * e), -power, 1e-6 * size);
  }
  loop.x = x;
}

inline std::vector<Vec3> run_steps(Loop& loop, Executor& executor, int steps, std::uint64_t first = 0) {
  for (int k = 0; k < steps; ++k) {
    shake(loop, 0.1, 0.1, 40 + first + static_cast<std::uint64_t>(k));
    for (Vec3& f : loop.force) f = Vec3(0.1, 0.2, 0.3);
    loop.forces->add_forces(loop.x, loop.v, 1e-6, executor, loop.force);
  }
  return loop.force;
}

}  // namespace volccd::simulation::test
