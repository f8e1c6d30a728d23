#include <volccd/oracle/cases/near_degenerate.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <volccd/oracle/cases/contact_builder.hpp>

namespace volccd::cases {
namespace {

/// More digits than the coordinates have.
using Real = long double;

using Point = std::array<Real, 3>;

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Real dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Real point_to_edge(const Point& p, const Point& a, const Point& b) {
  const Point d = b - a, e = p - a;
  const Real square = dot(d, d), s = square > 0 ? std::clamp<Real>(dot(e, d) / square, 0, 1) : 0;
  const Point gap{e[0] - s * d[0], e[1] - s * d[1], e[2] - s * d[2]};
  return std::sqrt(dot(gap, gap));
}

Real vertex_to_triangle(const std::array<Point, 4>& p) {
  Real min =
      std::min({point_to_edge(p[0], p[1], p[2]), point_to_edge(p[0], p[2], p[3]), point_to_edge(p[0], p[3], p[1])});
  const Point n = cross(p[2] - p[1], p[3] - p[1]);
  const Real square = dot(n, n);
  bool inside = square > 0;
  for (std::size_t i = 1; i <= 3; ++i) inside = inside && dot(cross(p[i % 3 + 1] - p[i], p[0] - p[i]), n) >= 0;
  return inside ? std::min(min, std::abs(dot(n, p[0] - p[1])) / std::sqrt(square)) : min;
}

Real edge_to_edge(const std::array<Point, 4>& p) {
  Real min = std::min({point_to_edge(p[0], p[2], p[3]), point_to_edge(p[1], p[2], p[3]),
                       point_to_edge(p[2], p[0], p[1]), point_to_edge(p[3], p[0], p[1])});
  const Point d = p[1] - p[0], e = p[3] - p[2], r = p[2] - p[0], n = cross(d, e);
  const Real square = dot(n, n);
  if (!(square > 0)) return min;
  const Real s = dot(cross(r, e), n) / square, u = dot(cross(r, d), n) / square;
  return s >= 0 && s <= 1 && u >= 0 && u <= 1 ? std::min(min, std::abs(dot(n, r)) / std::sqrt(square)) : min;
}

}  // namespace

Case near_degenerate(Choices& choices, FeatureKind kind, int control_points, std::size_t first, std::size_t second,
                     Separation separation) {
  ContactBuilder builder(choices, kind, control_points);
  builder.features();
  builder.fill(0, first);
  builder.fill(1, second);
  if (separation == Separation::some) builder.move_apart();
  builder.transform();
  builder.scale();
  builder.round_and_nudge();
  builder.reorder();
  return builder.build();
}

Case near_degenerate_test(Choices& choices, Separation separation) {
  const FeatureKind kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
  const int control_points = 2 + choices.below(2);
  return kind == FeatureKind::vf ? near_degenerate(choices, kind, control_points, 1, 3, separation)
                                 : near_degenerate(choices, kind, control_points, 2, 2, separation);
}

Coordinates::Coordinates(const Case& c) : kind_(c.kind), control_points_(c.control_points) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Curve& p = i < c.own(0) ? c.sets[0][i] : c.sets[1][i - c.own(0)];
    for (std::size_t k = 0; k < 9; ++k) points_[i][k] = p[k / 3][static_cast<int>(k % 3)];
  }
}

TestMotion Coordinates::motion() const {
  return {kind_, control_points_, {points_[0].data(), points_[1].data(), points_[2].data(), points_[3].data()}};
}

bool Coordinates::apart_along_an_axis() const {
  const std::size_t first = kind_ == FeatureKind::vf ? 1 : 2, n = 3 * static_cast<std::size_t>(control_points_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bool ahead = true, behind = true;
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = first; j < 4; ++j)
        for (std::size_t k = axis; k < n; k += 3) {
          ahead = ahead && points_[i][k] < points_[j][k];
          behind = behind && points_[i][k] > points_[j][k];
        }
    if (ahead || behind) return true;
  }
  return false;
}

double Coordinates::size() const {
  double size = 0;
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < 3 * static_cast<std::size_t>(control_points_); ++k)
        size = std::max(size, std::abs(points_[i][k] - points_[j][k]));
  return size;
}

long double Coordinates::distance(double t) const {
  std::array<Point, 4> p;
  const Real s = 1 - Real(t);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      // Positions are relative to the first point, because small distances would be lost in large coordinates.
      const auto x = [&](std::size_t control_point) {
        return Real(points_[i][k + 3 * control_point]) - Real(points_[0][k + 3 * control_point]);
      };
      p[i][k] = control_points_ == 2 ? s * x(0) + t * x(1) : s * (s * x(0) + 2 * t * x(1)) + t * (t * x(2));
    }
  return kind_ == FeatureKind::vf ? vertex_to_triangle(p) : edge_to_edge(p);
}

bool seen_within_separation(const Case& c, double from, double to, double* at) {
  const Coordinates x(c);
  constexpr int kSamples = 32;
  const double width = (to - from) / kSamples;
  double best = from;
  Real min = HUGE_VAL;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = i == kSamples ? to : from + i * width;
    const Real distance = x.distance(t);
    if (distance < min) min = distance, best = t;
  }
  double low = std::max(from, best - width), high = std::min(to, best + width);
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (x.distance(a) <= x.distance(b))
      high = b;
    else
      low = a;
  }
  const Real near = Real(c.separation) * (1 + 1e-6) + Real(x.size()) * 1e-12;
  for (const double t : {best, low, high, to}) {  // distances to slivers may be wrong, the comparison is exact
    if (x.distance(t) > near || compare_distance(x.motion(), t, c.separation) > 0) continue;
    *at = t;
    return true;
  }
  return false;
}

bool touches(const Case& c, double t_max) {
  if (c.touch >= 0 && c.touch <= t_max) return true;
  double at;
  if (c.separation > 0) return seen_within_separation(c, 0, t_max, &at);
  const Coordinates x(c);
  return !x.apart_along_an_axis() && exact_first_touch(x.motion(), t_max).touches;
}

std::string to_text(const Case& c) {
  char text[128];
  std::string all = c.kind == FeatureKind::vf ? "VF" : "EE";
  std::snprintf(text, sizeof text, ", %d control points, separation %a, touch by %a\n", c.control_points, c.separation,
                c.touch);
  all += text;
  for (const auto& set : c.sets) {
    for (const Curve& p : set) {
      for (std::size_t k = 0; k < static_cast<std::size_t>(c.control_points); ++k) {
        std::snprintf(text, sizeof text, "  {%a, %a, %a},", p[k].x(), p[k].y(), p[k].z());
        all += text;
      }
      all += "\n";
    }
    all += "\n";
  }
  return all;
}

}  // namespace volccd::cases
