// Vectors and moving points of the 2011 reference implementation. Its scalar code is a template on the number type, so
// that the code that is timed with doubles can count its operations with another type.
#pragma once

#include <span>
#include <vector>

#include <volccd/numerics/vector3.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::reference {

using detail::cross;
using detail::dot;
using detail::operator-;
using detail::Vector3;

/// A vertex that moves with constant velocity during the step: its positions at t = 0 and at t = 1.
template <class Scalar>
struct MovingPoint {
  Vector3<Scalar> x0, x1;
};

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
