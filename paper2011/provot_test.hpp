// The elementary test as Provot 1997 and Bridson et al. 2002 published it: finds the times at which four moving points
// are coplanar, and tests at each whether the two features touch. Scalar template over any number type. The stage that
// uses it is in paper2011/provot.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <volccd/paper2011/reference_vectors.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::reference {

template <class Scalar>
struct ProvotAnswer {
  bool touches = false;
  bool degenerate = false;  ///< the triangle had no area, or the edges were parallel, at a root that was examined
  Scalar t = 0;             ///< time of the contact
  /// Sign of the coplanarity cubic before the contact (at t = 0, with the motion extrapolated backwards); 0 if it
  /// vanished.
  int side = 0;
};

/// Positions at t = 0 and velocities of points 1, 2, 3 relative to point 0. In this file, points are in the order of
/// test_vertices().
template <class Scalar>
struct RelativeMotion {
  std::array<Vector3<Scalar>, 3> x, v;

  explicit RelativeMotion(const std::array<MovingPoint<Scalar>, 4>& points) {
    for (std::size_t i = 0; i < 3; ++i) {
      x[i] = points[i + 1].x0 - points[0].x0;
      v[i] = (points[i + 1].x1 - points[0].x1) - x[i];
    }
  }
  Vector3<Scalar> at(std::size_t i, const Scalar& t) const {
    return {x[i][0] + t * v[i][0], x[i][1] + t * v[i][1], x[i][2] + t * v[i][2]};
  }
};

/// a t^3 + b t^2 + c t + d = determinant of the three relative positions at t: six times the volume of the tetrahedron.
template <class Scalar>
struct ProvotCubic {
  Scalar a, b, c, d;

  explicit ProvotCubic(const RelativeMotion<Scalar>& m) {
    const Vector3<Scalar> n0 = cross(m.x[0], m.x[1]), n2 = cross(m.v[0], m.v[1]);
    const Vector3<Scalar> p = cross(m.x[0], m.v[1]), q = cross(m.v[0], m.x[1]);
    const Vector3<Scalar> n1 = {p[0] + q[0], p[1] + q[1], p[2] + q[2]};
    a = dot(n2, m.v[2]);
    b = dot(n2, m.x[2]) + dot(n1, m.v[2]);
    c = dot(n1, m.x[2]) + dot(n0, m.v[2]);
    d = dot(n0, m.x[2]);
  }
  Scalar value(const Scalar& t) const { return ((a * t + b) * t + c) * t + d; }
  Scalar derivative(const Scalar& t) const { return (Scalar(3) * a * t + Scalar(2) * b) * t + c; }

  /// Writes 0, the critical points in ]0,1[ in ascending order, and 1, between which the cubic is monotone. Returns the
  /// number of these intervals.
  std::size_t monotone_pieces(std::array<Scalar, 4>& cuts) const {
    using std::sqrt;
    std::size_t count = 0;
    cuts[0] = Scalar(0);
    const Scalar discriminant = b * b - Scalar(3) * a * c;
    if (discriminant > Scalar(0)) {
      const Scalar root = sqrt(discriminant), q = b < Scalar(0) ? root - b : -(b + root);
      std::array<Scalar, 2> critical = {c / q, q / (Scalar(3) * a)};
      if (critical[1] < critical[0]) critical = {critical[1], critical[0]};
      for (const Scalar& t : critical)
        if (t > Scalar(0) && t < Scalar(1)) cuts[++count] = t;
    }
    cuts[++count] = Scalar(1);
    return count;
  }
};

/// Sign of a value: -1, 0 or 1; 0 for NaN.
template <class Scalar>
int sign_of(const Scalar& value) {
  return value > Scalar(0) ? 1 : value < Scalar(0) ? -1 : 0;
}

/// The root of f in [low, high], an interval in which f is monotone and has opposite signs at the ends: Newton's
/// method, replaced by bisection where it would leave the bracket. Accurate to about 1e-13 for a single root.
template <class Scalar>
Scalar bracketed_root(const ProvotCubic<Scalar>& f, Scalar low, Scalar high, const Scalar& f_low,
                      const Scalar& f_high) {
  constexpr int kMaxSteps = 64;
  const Scalar accuracy = 0x1p-44;
  const bool rising = f_low < Scalar(0);
  Scalar t = low + (high - low) * (f_low / (f_low - f_high));
  for (int i = 0; i < kMaxSteps; ++i) {
    const Scalar value = f.value(t);
    const int sign = sign_of(value);
    if (sign == 0) break;
    ((sign < 0) == rising ? low : high) = t;
    Scalar next = t - value / f.derivative(t);
    if (!(next >= low && next <= high)) next = Scalar(0.5) * (low + high);
    const Scalar step = next - t;
    t = next;
    if (step <= accuracy && -accuracy <= step) break;
  }
  return t;
}

/// Whether a weight is in [0,1], or outside by at most `tolerance`.
template <class Scalar>
bool within(const Scalar& weight, const Scalar& tolerance) {
  return weight >= -tolerance && weight <= Scalar(1) + tolerance;
}

/// A squared area relative to the product of the squared sides (for edges: squared sine of their angle) is regarded as
/// zero below this value.
inline constexpr double kMinSquaredSine = 1e-14;

/// Whether the origin is inside the triangle d, at a time when it is in the plane of the triangle: barycentric
/// coordinates by normal equations (Bridson et al., Section 6).
template <class Scalar>
bool inside_triangle(const std::array<Vector3<Scalar>, 3>& d, const Scalar& tolerance, bool& degenerate) {
  const Vector3<Scalar> e1 = d[0] - d[2], e2 = d[1] - d[2];
  const Scalar aa = dot(e1, e1), ab = dot(e1, e2), bb = dot(e2, e2), area = aa * bb - ab * ab;
  if (!(area > Scalar(kMinSquaredSine) * (aa * bb))) {
    degenerate = true;
    return false;
  }
  const Scalar p = -dot(e1, d[2]), q = -dot(e2, d[2]);
  const Scalar w0 = (p * bb - q * ab) / area, w1 = (q * aa - p * ab) / area;
  return within(w0, tolerance) && within(w1, tolerance) && within(Scalar(1) - w0 - w1, tolerance);
}

/// Whether the distance from p to the segment that starts at `from` with direction e is at most sqrt(most). Pre: e . e
/// = ee.
template <class Scalar>
bool near_segment(const Vector3<Scalar>& p, const Vector3<Scalar>& from, const Vector3<Scalar>& e, const Scalar& ee,
                  const Scalar& max) {
  const Vector3<Scalar> r = p - from;
  Scalar s = ee > Scalar(0) ? dot(r, e) / ee : Scalar(0);
  if (s < Scalar(0)) s = Scalar(0);
  if (s > Scalar(1)) s = Scalar(1);
  const Vector3<Scalar> gap = {r[0] - s * e[0], r[1] - s * e[1], r[2] - s * e[2]};
  return dot(gap, gap) <= max;
}

/// Whether the edge from the origin to d[0] and the edge from d[1] to d[2] intersect, at a time when they are coplanar.
/// For parallel edges: whether an end of one edge is within `tolerance` times the longer edge of the other edge.
template <class Scalar>
bool edges_meet(const std::array<Vector3<Scalar>, 3>& d, const Scalar& tolerance, bool& degenerate) {
  const Vector3<Scalar>&e1 = d[0], e2 = d[2] - d[1];
  const Scalar aa = dot(e1, e1), ab = dot(e1, e2), bb = dot(e2, e2), area = aa * bb - ab * ab;
  if (area > Scalar(kMinSquaredSine) * (aa * bb)) {
    const Scalar p = dot(e1, d[1]), q = dot(e2, d[1]);
    return within((p * bb - q * ab) / area, tolerance) && within((p * ab - q * aa) / area, tolerance);
  }
  degenerate = true;
  const Scalar max = tolerance * tolerance * (aa > bb ? aa : bb);
  const Vector3<Scalar> origin = {Scalar(0), Scalar(0), Scalar(0)};
  return near_segment(origin, d[1], e2, bb, max) || near_segment(d[0], d[1], e2, bb, max) ||
         near_segment(d[1], origin, e1, aa, max) || near_segment(d[2], origin, e1, aa, max);
}

/// One elementary test on [0, t_max]: finds the first root of the cubic at which the features touch. If the cubic is 0
/// at both ends of the step (for example because the points are always coplanar), only these two times are examined.
template <class Scalar>
ProvotAnswer<Scalar> provot_test(FeatureKind kind, const std::array<MovingPoint<Scalar>, 4>& points,
                                 const Scalar& tolerance, const Scalar& t_max) {
  const RelativeMotion<Scalar> motion(points);
  const ProvotCubic<Scalar> cubic(motion);
  ProvotAnswer<Scalar> answer;
  const auto touches_at = [&](const Scalar& t, int side) {
    if (!(t <= t_max)) return false;
    const std::array<Vector3<Scalar>, 3> d = {motion.at(0, t), motion.at(1, t), motion.at(2, t)};
    answer.touches = kind == FeatureKind::vf ? inside_triangle(d, tolerance, answer.degenerate)
                                             : edges_meet(d, tolerance, answer.degenerate);
    answer.t = t;
    answer.side = side;
    return answer.touches;
  };
  std::array<Scalar, 4> cuts;
  const std::size_t pieces = cubic.monotone_pieces(cuts);
  Scalar low = cubic.value(cuts[0]);
  int before = sign_of(low);
  for (std::size_t k = 0; k < pieces && cuts[k] <= t_max; ++k) {
    const Scalar high = cubic.value(cuts[k + 1]);
    const int after = sign_of(high);
    if (k == 0 && before == 0 && touches_at(cuts[0], -after)) break;
    if (before * after < 0 && touches_at(bracketed_root(cubic, cuts[k], cuts[k + 1], low, high), before)) break;
    if (after == 0 && touches_at(cuts[k + 1], before)) break;
    low = high;
    before = after;
  }
  return answer;
}

}  // namespace volccd::reference
