// Vectors and moving points of the reference implementation of 2011: scalar code over a number type of the caller's
// choice, so that the same code that is timed with double counts its operations with another type.
#pragma once

#include <volccd/query/vector3.hpp>

namespace volccd::reference {

using detail::cross;
using detail::dot;
using detail::operator-;
using detail::Vector3;

/// A vertex that moves with constant velocity during the step: positions at t = 0 and at t = 1.
template <class Scalar>
struct MovingPoint {
  Vector3<Scalar> x0, x1;
};

}  // namespace volccd::reference
