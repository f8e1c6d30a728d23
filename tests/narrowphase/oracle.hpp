// An independent judge of elementary tests in long double: distances by Voronoi regions (Ericson, Real-Time Collision
// Detection, 5.1), contacts by dense sampling, absence of contacts by conservative advancement. It shares no code with
// the library's tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "query_set.hpp"

#include <volccd/query/pairs.hpp>

namespace volccd::test {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;
using Points = std::array<Point, 4>;

inline Points points_at(const Query& q, Real t) {
  Points p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = (1 - t) * q[i].cast<Real>() + t * q[i + 4].cast<Real>();
  return p;
}

inline Real triangle_region_distance(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const Real d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - ab * (d1 / (d1 - d3))).norm();
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - ac * (d2 / (d2 - d6))).norm();
  const Real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return (bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).norm();
  return (ap - ab * (vb / (va + vb + vc)) - ac * (vc / (va + vb + vc))).norm();
}

inline Real segment_segment_distance(const Point& p1, const Point& q1, const Point& p2, const Point& q2) {
  const auto clamp = [](Real x) { return std::clamp<Real>(x, 0, 1); };
  const Point d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const Real a = d1.dot(d1), e = d2.dot(d2), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  Real s = 0, t = 0;
  if (a == 0 && e == 0) return r.norm();
  if (a == 0) {
    t = clamp(f / e);
  } else if (e == 0) {
    s = clamp(-c / a);
  } else {
    const Real denominator = a * e - b * b;
    if (denominator > 0) s = clamp((b * f - c * e) / denominator);
    t = (b * s + f) / e;
    if (t < 0 || t > 1) {
      t = clamp(t);
      s = clamp((b * t - c) / a);
    }
  }
  return (r + d1 * s - d2 * t).norm();
}

/// For slivers, rounding decides the signs that choose the regions. Therefore the boundary is always examined.
inline Real point_triangle_distance(const Point& p, const Point& a, const Point& b, const Point& c) {
  return std::min({triangle_region_distance(p, a, b, c), segment_segment_distance(p, p, a, b),
                   segment_segment_distance(p, p, b, c), segment_segment_distance(p, p, c, a)});
}

inline Real distance_at(FeatureKind kind, const Query& q, Real t) {
  const Points p = points_at(q, t);
  return kind == FeatureKind::vf ? point_triangle_distance(p[0], p[1], p[2], p[3])
                                 : segment_segment_distance(p[0], p[1], p[2], p[3]);
}

inline Real volume_at(const Query& q, Real t) {
  const Points p = points_at(q, t);
  return (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0]));
}

/// Whether the projections of the features along their normal cross, by a margin.
inline bool clearly_inside(FeatureKind kind, const Query& q, Real t, Real margin) {
  const Points p = points_at(q, t);
  const bool vf = kind == FeatureKind::vf;
  const Point e1 = vf ? Point(p[2] - p[1]) : Point(p[1] - p[0]), e2 = vf ? Point(p[3] - p[1]) : Point(p[3] - p[2]);
  const Point r = vf ? Point(p[0] - p[1]) : Point(p[2] - p[0]), n = e1.cross(e2);
  if (n.norm() < margin * e1.norm() * e2.norm()) return false;
  const Real x = n.dot(r.cross(e2)) / n.squaredNorm(), y = n.dot(vf ? e1.cross(r) : r.cross(e1)) / n.squaredNorm();
  if (vf) return x > margin && y > margin && x + y < 1 - margin;
  return x > margin && x < 1 - margin && y > margin && y < 1 - margin;
}

/// The first time at which sampling finds that the features certainly pass through each other.
inline std::optional<Real> sampled_contact(FeatureKind kind, const Query& q, int samples) {
  Real last = volume_at(q, 0);
  for (int i = 1; i <= samples; ++i) {
    Real b = Real(i) / samples, a = Real(i - 1) / samples;
    const Real volume = volume_at(q, b);
    if (last * volume < 0 && clearly_inside(kind, q, a, Real(1e-3)) && clearly_inside(kind, q, b, Real(1e-3))) {
      for (int turn = 0; turn < 70; ++turn) {
        const Real m = (a + b) / 2;
        (volume_at(q, m) * last > 0 ? a : b) = m;
      }
      if (clearly_inside(kind, q, b, Real(1e-3))) return b;
    }
    last = volume;
  }
  return std::nullopt;
}

inline Real size_of(const Query& q) {
  Real size = 0;
  for (std::size_t i : {1u, 2u, 3u, 5u, 6u, 7u})
    size = std::max(size, (q[i] - q[i < 4 ? 0 : 4]).cast<Real>().cwiseAbs().maxCoeff());
  return size;
}

/// Whether the features always stay further apart than `distance`, examined in steps that are too short to reach it.
inline bool proven_apart(FeatureKind kind, const Query& q, Real distance) {
  Real speed = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      speed = std::max(speed, ((q[i + 4] - q[i]) - (q[j + 4] - q[j])).cast<Real>().norm());
  for (Real t = 0; t <= 1;) {
    const Real gap = distance_at(kind, q, t) - distance / 2;
    if (gap < distance / 2) return false;
    if (speed == 0) return true;
    t += gap / speed;
  }
  return true;
}

}  // namespace volccd::test
