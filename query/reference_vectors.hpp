// Vectors and moving points of the 2011 reference implementation. Its scalar code is a template on the number type, so
// that the code that is timed with doubles can count its operations with another type.
#pragma once

#include <volccd/query/vector3.hpp>

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

}  // namespace volccd::reference
