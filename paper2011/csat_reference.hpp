// CSAT as the paper prints it: Theorem 1, Corollaries 1 to 4, with the signs of dot products (Section 4). Scalar
// templates over any number type. The signs are those of rounded values, so that nothing here is conservative in
// floating point (in contrast to culling/csat/csat.hpp). The stages that use this code are in paper2011/csat_2011.hpp.
#pragma once

#include <array>
#include <span>

#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd::reference {

/// The common sign of a sequence of values. A zero or NaN among them means "not separated".
class CommonSign {
 public:
  /// Whether all values up to and including this one have the same sign.
  template <class Scalar>
  bool add(const Scalar& value) {
    const int sign = value > Scalar(0) ? 1 : value < Scalar(0) ? -1 : 0;
    if (sign == 0 || sign * sign_ < 0) return false;
    sign_ = sign;
    return true;
  }

 private:
  int sign_ = 0;
};

/// Corollaries 2 and 4: whether (q - p) . L has the same sign for every p of `feature` (a vertex, or the ends of an
/// edge) and q of `element`, at both ends of the step. Two dot products for each p and q, until one decides.
template <class Scalar>
bool apart_along(const Vector3<Scalar>& axis, std::span<const MovingPoint<Scalar>> feature,
                 std::span<const MovingPoint<Scalar>> element) {
  CommonSign sign;
  for (const MovingPoint<Scalar>& p : feature)
    for (const MovingPoint<Scalar>& q : element)
      if (!sign.add(dot(q.x0 - p.x0, axis)) || !sign.add(dot(q.x1 - p.x1, axis))) return false;
  return true;
}

/// Normal of a triangle at t = 0.
template <class Scalar>
Vector3<Scalar> start_normal(const std::array<MovingPoint<Scalar>, 3>& f) {
  return cross(f[1].x0 - f[0].x0, f[2].x0 - f[0].x0);
}

/// Corollary 1 along the normal n0 of the triangle at t = 0: 4 dot products, since those at t = 0 are assumed to be
/// equal.
template <class Scalar>
bool vertex_apart(const MovingPoint<Scalar>& p, const std::array<MovingPoint<Scalar>, 3>& f,
                  const Vector3<Scalar>& n0) {
  CommonSign sign;
  return sign.add(dot(f[0].x0 - p.x0, n0)) && sign.add(dot(f[0].x1 - p.x1, n0)) && sign.add(dot(f[1].x1 - p.x1, n0)) &&
         sign.add(dot(f[2].x1 - p.x1, n0));
}

/// (a0 - b0) x (c0 - d0) of two edges at t = 0.
template <class Scalar>
Vector3<Scalar> start_cross(const std::array<MovingPoint<Scalar>, 2>& e, const std::array<MovingPoint<Scalar>, 2>& g) {
  return cross(e[0].x0 - e[1].x0, g[0].x0 - g[1].x0);
}

/// Corollary 3 along n0 = start_cross(e, g): 5 dot products, since those at t = 0 are assumed to be equal.
template <class Scalar>
bool edges_apart(const std::array<MovingPoint<Scalar>, 2>& e, const std::array<MovingPoint<Scalar>, 2>& g,
                 const Vector3<Scalar>& n0) {
  CommonSign sign;
  return sign.add(dot(e[0].x0 - g[0].x0, n0)) && sign.add(dot(e[0].x1 - g[0].x1, n0)) &&
         sign.add(dot(e[1].x1 - g[0].x1, n0)) && sign.add(dot(e[0].x1 - g[1].x1, n0)) &&
         sign.add(dot(e[1].x1 - g[1].x1, n0));
}

}  // namespace volccd::reference
