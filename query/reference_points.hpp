// Trajectories of a motion in the form that the reference implementation of 2011 takes.
#pragma once

#include <span>
#include <vector>

#include <volccd/query/motion.hpp>
#include <volccd/query/reference_vectors.hpp>

namespace volccd::reference {

/// Pre: the motion has two control points.
inline MovingPoint<double> moving_point(const Motion& motion, Index v) {
  const double* x = motion.at(v);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}

/// Pre: the motion has two control points.
inline std::vector<MovingPoint<double>> moving_points(const Motion& motion, std::span<const Index> vertices) {
  std::vector<MovingPoint<double>> result;
  for (const Index v : vertices) result.push_back(moving_point(motion, v));
  return result;
}

}  // namespace volccd::reference
