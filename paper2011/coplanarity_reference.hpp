// The non-penetration filter (coplanarity-based culling) of Tang, Manocha and Tong 2010, with which Section 7.2
// compares CSAT: a scalar template over any number type, with the signs of rounded values, like
// paper2011/csat_reference.hpp. The stage of this filter is in culling/filters/coplanarity_filter.hpp.
#pragma once

#include <array>

#include <volccd/paper2011/csat_reference.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::reference {

/// Whether w(t) . (u(t) x v(t)) has Bernstein coefficients of one sign, for vectors that change linearly from their
/// first value to their second: then it has no root in [0, 1]. The coefficients, up to a factor, are computed one after
/// the other, first those at both ends, until one decides: at most 35 additions and 36 multiplications.
template <class Scalar>
bool determinant_keeps_sign(const std::array<Vector3<Scalar>, 2>& u, const std::array<Vector3<Scalar>, 2>& v,
                            const std::array<Vector3<Scalar>, 2>& w) {
  CommonSign sign;
  const Vector3<Scalar> n0 = cross(u[0], v[0]), n1 = cross(u[1], v[1]);
  if (!sign.add(dot(w[0], n0)) || !sign.add(dot(w[1], n1))) return false;
  const Vector3<Scalar> change = cross(u[1] - u[0], v[1] - v[0]);
  const Vector3<Scalar> middle = {n0[0] + n1[0] - change[0], n0[1] + n1[1] - change[1], n0[2] + n1[2] - change[2]};
  return sign.add(dot(w[0], middle) + dot(w[1], n0)) && sign.add(dot(w[1], middle) + dot(w[0], n1));
}

/// Whether the four points of a test, in the order of test_vertices(), are coplanar at no time in [0, 1].
template <class Scalar>
bool never_coplanar(FeatureKind kind, const std::array<MovingPoint<Scalar>, 4>& p) {
  const auto from_to = [&](std::size_t a, std::size_t b) -> std::array<Vector3<Scalar>, 2> {
    return {p[b].x0 - p[a].x0, p[b].x1 - p[a].x1};
  };
  return kind == FeatureKind::vf ? determinant_keeps_sign(from_to(1, 2), from_to(1, 3), from_to(0, 1))
                                 : determinant_keeps_sign(from_to(0, 1), from_to(2, 3), from_to(0, 2));
}

}  // namespace volccd::reference
