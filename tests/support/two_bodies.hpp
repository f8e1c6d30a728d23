// Two bodies of one shape, close to each other.
#pragma once

#include <algorithm>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd::test {

/// Objects 1 and 2 of this shape, with permuted ids; the second one is `gap` above the first, and aside.
inline Shape two_bodies(const Shape& shape, double gap) {
  Shape both, other = shape;
  double height = 0;
  for (const Vec3& p : shape.positions) height = std::max(height, p.z());
  both.append(shape, 1);
  both.append(other.translate(Vec3(0.31, 0.27, height + gap)), 2);
  return permuted(both, 5);
}

}  // namespace volccd::test
