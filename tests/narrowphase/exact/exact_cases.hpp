// Motions of two features with few or simple numbers, and an independent judge of their times of contact: conservative
// advancement on distances in long double.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact/exact.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>

#include "narrowphase/oracle.hpp"

namespace volccd::test::exact_decision {

using Corners = std::array<Vec3, 4>;

/// Control points of four points: the first one of each point, then the second one of each, and so on.
struct Case {
  FeatureKind kind;
  std::vector<Corners> control;

  ExactAnswer answer(double t_max = 1, double separation = 0) const {
    const auto x = packed();
    return exact_first_touch(motion(x), t_max, separation);
  }
  int compare(double t, double d) const {
    const auto x = packed();
    return compare_distance(motion(x), t, d);
  }
  Points at(Real t) const {
    const auto between = [t](const Corners& a, const Corners& b) {
      Points p;
      for (std::size_t i = 0; i < 4; ++i) p[i] = (1 - t) * a[i].cast<Real>() + t * b[i].cast<Real>();
      return p;
    };
    const Points first = between(control[0], control[1]);
    if (control.size() == 2) return first;
    const Points second = between(control[1], control[2]);
    Points p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = (1 - t) * first[i] + t * second[i];
    return p;
  }
  Real distance(Real t) const {
    const Points p = at(t);
    if (kind == FeatureKind::ee) return segment_segment_distance(p[0], p[1], p[2], p[3]);
    const Real sides =
        std::min({segment_segment_distance(p[0], p[0], p[1], p[2]), segment_segment_distance(p[0], p[0], p[2], p[3]),
                  segment_segment_distance(p[0], p[0], p[3], p[1])});
    return std::fmin(sides, triangle_region_distance(p[0], p[1], p[2], p[3]));  // it is NaN if there is no area
  }
  template <class Change>
  Case with(Change change) const {
    Case other = *this;
    for (Corners& corners : other.control) change(corners);
    return other;
  }

 private:
  using Packed = std::array<std::array<double, 9>, 4>;
  Packed packed() const {
    Packed x{};
    for (std::size_t c = 0; c < control.size(); ++c)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 3; ++k) x[i][3 * c + k] = control[c][i][static_cast<Eigen::Index>(k)];
    return x;
  }
  TestMotion motion(const Packed& x) const {
    return {kind, static_cast<int>(control.size()), {x[0].data(), x[1].data(), x[2].data(), x[3].data()}};
  }
};

inline constexpr FeatureKind vf = FeatureKind::vf, ee = FeatureKind::ee;
inline constexpr double kDenormal = 0x1p-1074, kUlp = 0x1p-52;

/// A vertex, and the triangle (0,0,0), (1,0,0), (0,1,0) at rest.
inline Case against_triangle(std::vector<Vec3> path) {
  Case c{vf, {}};
  for (const Vec3& p : path) c.control.push_back({p, Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)});
  return c;
}

/// The time at which the features come within 1e-8 of the separation, found with steps that are too short to pass it;
/// above 1 if they do not. Speeds are bounded by differences of control points.
inline Real advance(const Case& c, Real separation = 0) {
  const auto degree = static_cast<Real>(c.control.size() - 1);
  Real speed = 1e-9L, t = 0;
  for (std::size_t k = 0; k + 1 < c.control.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        speed =
            std::max(speed, degree * ((c.control[k + 1][i] - c.control[k][i]) - (c.control[k + 1][j] - c.control[k][j]))
                                         .cast<Real>()
                                         .norm());
  while (t <= 1) {
    const Real gap = c.distance(t) - separation;
    if (gap < 1e-8L) return t;
    t += gap / speed;
  }
  return t;
}

/// Integer coordinates in [0, range). Small ranges give many degenerate cases. Some points share coordinates or do not
/// move.
inline Case lattice_case(FeatureKind kind, std::size_t control_points, Random& random) {
  Case c{kind, {}};
  const std::uint64_t range = 2 + random.below(6), flat = random.below(4), still = random.below(6);
  for (std::size_t k = 0; k < control_points; ++k) {
    Corners x;
    for (std::size_t i = 0; i < 4; ++i) {
      for (Eigen::Index a = 0; a < 3; ++a) x[i][a] = static_cast<double>(random.below(range));
      if (flat == 0) x[i].z() = 0;
      if (flat == 1) x[i].z() = x[i].x() + x[i].y();
      if (k > 0 && i == still) x[i] = c.control[0][i];
    }
    c.control.push_back(x);
  }
  return c;
}

/// Calls f for 250 lattice cases of each kind and each number of control points.
template <class F>
void for_lattice_cases(std::uint64_t seed, F f) {
  Random random(seed);
  for (const FeatureKind kind : {vf, ee})
    for (const std::size_t control_points : {2u, 3u})
      for (int i = 0; i < 250; ++i) {
        const Case c = lattice_case(kind, control_points, random);
        SCOPED_TRACE(testing::Message() << (kind == vf ? "VF " : "EE ") << control_points << " case " << i);
        f(c, random);
      }
}

}  // namespace volccd::test::exact_decision
