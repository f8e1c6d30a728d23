// Every contact of a small step by the simplest method: all feature pairs, and roots of the coplanarity cubic by
// bisection. For motions in general position only.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <volccd/query/contact.hpp>
#include <volccd/query/step.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::test {

namespace naive {

/// Real coefficients, lowest first.
inline std::vector<double> roots_in_step(const std::array<double, 4>& c) {
  const auto value = [&](double t) { return ((c[3] * t + c[2]) * t + c[1]) * t + c[0]; };
  std::vector<double> cuts = {0, 1};
  const double a = 3 * c[3], b = 2 * c[2], d = c[1], disc = b * b - 4 * a * d;
  if (std::abs(a) < 1e-14) {
    if (std::abs(b) > 1e-14) cuts.push_back(-d / b);
  } else if (disc >= 0) {
    cuts.push_back((-b - std::sqrt(disc)) / (2 * a));
    cuts.push_back((-b + std::sqrt(disc)) / (2 * a));
  }
  std::erase_if(cuts, [](double t) { return !(t >= 0 && t <= 1); });
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    double low = cuts[i], high = cuts[i + 1];
    if ((value(low) > 0) == (value(high) > 0)) continue;
    const bool up = value(high) > 0;
    for (int k = 0; k < 60; ++k) (value((low + high) / 2) > 0) == up ? high = (low + high) / 2 : low = (low + high) / 2;
    roots.push_back(high);
  }
  return roots;
}

inline bool inside(FeatureKind kind, const std::array<Vec3, 4>& x) {
  const double tolerance = 1e-7;
  Eigen::Matrix<double, 3, 2> m;
  Vec3 r;
  if (kind == FeatureKind::vf) {
    m << x[2] - x[1], x[3] - x[1];
    r = x[0] - x[1];
  } else {
    m << x[1] - x[0], x[2] - x[3];
    r = x[2] - x[0];
  }
  const Eigen::Vector2d w = (m.transpose() * m).inverse() * (m.transpose() * r);
  if (kind == FeatureKind::vf) return w[0] >= -tolerance && w[1] >= -tolerance && w.sum() <= 1 + tolerance;
  return w.minCoeff() >= -tolerance && w.maxCoeff() <= 1 + tolerance;
}

inline std::optional<double> first_touch(const Step& step, FeatureKind kind, const std::array<Index, 4>& v) {
  std::array<Vec3, 4> x, dx;
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = step.motion.point(v[i], 0);
    dx[i] = step.motion.point(v[i], 1) - x[i];
  }
  std::array<Vec3, 3> e, de;
  for (std::size_t i = 0; i < 3; ++i) {
    e[i] = x[i + 1] - x[0];
    de[i] = dx[i + 1] - dx[0];
  }
  const auto det = [](const Vec3& a, const Vec3& b, const Vec3& c) { return a.cross(b).dot(c); };
  const std::array<double, 4> c = {
      det(e[0], e[1], e[2]), det(de[0], e[1], e[2]) + det(e[0], de[1], e[2]) + det(e[0], e[1], de[2]),
      det(de[0], de[1], e[2]) + det(de[0], e[1], de[2]) + det(e[0], de[1], de[2]), det(de[0], de[1], de[2])};
  for (const double t : roots_in_step(c)) {
    std::array<Vec3, 4> y;
    for (std::size_t i = 0; i < 4; ++i) y[i] = x[i] + t * dx[i];
    if (inside(kind, y)) return t;
  }
  return std::nullopt;
}

}  // namespace naive

inline std::vector<Contact> naive_contacts(const Step& step) {
  const Features& features = step.features();
  std::vector<Contact> contacts;
  const auto test = [&](FeatureKind kind, FeaturePair pair) {
    if (!is_test(features, kind, pair)) return;
    const std::array<Index, 4> v = test_vertices(features, kind, pair);
    if (const auto t = naive::first_touch(step, kind, v))
      contacts.push_back({kind, v, *t, Vec3::Zero(), {1, 0, 0, 0}, Vec3::Zero()});
  };
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.vertex_elements(v).empty() && !features.triangle_elements(f).empty()) test(FeatureKind::vf, {v, f});
  for (Index e = 0; e < features.edge_slots(); ++e)
    for (Index f = e + 1; f < features.edge_slots(); ++f)
      if (!features.edge_elements(e).empty() && !features.edge_elements(f).empty()) test(FeatureKind::ee, {e, f});
  return contacts;
}

}  // namespace volccd::test
