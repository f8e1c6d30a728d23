#include "conservative/near_degenerate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <Eigen/Dense>

namespace volccd::test {
namespace {

/// More digits: sums of what the builder makes are exact.
using Real = long double;

/// Position, velocity and half the acceleration at the time of contact: dyadic numbers of few bits, so that what is
/// made of them is exact.
struct Path {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero(), a = Vec3::Zero();

  friend Path operator+(const Path& p, const Path& q) { return {p.x + q.x, p.v + q.v, p.a + q.a}; }
  friend Path operator*(double w, const Path& p) { return {w * p.x, w * p.v, w * p.a}; }
  Curve curve(int control_points, double t) const {
    const Vec3 start = x - t * v + t * t * a, end = x + (1 - t) * v + (1 - t) * (1 - t) * a;
    if (control_points == 2) return {start, end, end};
    return {start, x + (0.5 - t) * v + (t * t - t) * a, end};
  }
};

class Builder {
 public:
  Builder(Choices& choices, FeatureKind kind, int control_points) : c_(choices) {
    case_.kind = kind;
    case_.control_points = control_points;
    range_ = static_cast<int>(c_.pick({1, 2, 5, 16, 1000, 1 << 18}));
    speed_ = static_cast<int>(c_.pick({0, 1, 1, 16, 1000, 1 << 18}));
    case_.touch = t_ = c_.pick({0, 1, 0.5, 0.25, 0.75, 0.125});
    between_ = static_cast<Between>(c_.below(3));
    drift_ = c_.one_in(2) ? lattice(1 << 18) : Vec3(Vec3::Zero());
  }

  Case take() { return std::move(case_); }

  void vertex_and_triangle() {
    Path b[3] = {path(), path(), path()};
    const int shape = c_.below(8);
    if (shape == 5) b[2] = b[1];
    if (shape == 6) b[1] = b[2] = b[0];
    if (shape == 7) b[2] = 2.0 * b[1] + -1.0 * b[0];
    double w[3] = {1, 0, 0};
    const int place = c_.below(3);
    if (place == 1) w[0] = 0.5, w[1] = 0.5;
    if (place == 2) {
      w[0] = c_.below(17) / 16.0;
      w[1] = c_.below(static_cast<int>(16 * (1 - w[0])) + 1) / 16.0;
      w[2] = 1 - w[0] - w[1];
    }
    const Path contact = w[0] * b[0] + w[1] * b[1] + w[2] * b[2];
    add(0, meeting(contact, b[1].x - b[0].x, b[2].x - b[0].x), true);
    for (int i = 0; i < 3; ++i) add(1, b[i], w[i] > 0);
  }

  void two_edges() {
    Path a[2] = {path(), path()}, b[2] = {path(), {}};
    const int shape = c_.below(8);
    if (shape == 7) a[1] = a[0];
    const double s = c_.pick({0, 1, 0.5, 0.25, 0.0625, 0.9375}), u = c_.pick({1, 0.5, 0.25, 0.0625});
    const Path contact = (1 - s) * a[0] + s * a[1];
    if (shape == 5) b[0] = contact;
    if (shape == 6) b[0].x = contact.x + c_.lattice(3) * (a[1].x - a[0].x);
    b[1] = (1 / u) * (meeting(contact, a[1].x - a[0].x, contact.x - b[0].x) + (u - 1) * b[0]);
    add(0, a[0], s < 1);
    add(0, a[1], s > 0);
    add(1, b[0], u < 1);
    add(1, b[1], true);
  }

  void fill(std::size_t set, std::size_t count) {
    while (case_.sets[set].size() < count) add(set, path(), false);
  }

  /// Moves the first set off by a vector of exactly known length.
  void move_apart() {
    lift_ = c_.pick({1, 2, 0.5, 16, 0.0009765625, 1 << 18});
    case_.separation = lift_;
    for (Curve& p : case_.sets[0])
      for (Vec3& x : p) x.z() += lift_;
  }

  /// An affine map that is exact.
  void transform() {
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    const int which = c_.below(case_.separation > 0 ? 3 : 7);
    if (which == 1) m << 1, 2, 2, 2, -2, 1, 2, 1, -2;
    if (which == 2) m << 2, 3, 6, 3, -6, 2, 6, 2, -3;
    if (which == 3 || which == 4) m << 1, 0, 1, 0, 1, 1, -1, -1, 1;
    if (which == 5) m << 1, 0, 1, -1, 0, 1, 0, 1, 0;
    if (which == 6)
      for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = c_.lattice(3);
    case_.separation *= which == 1 ? 3 : which == 2 ? 7 : 1;
    Curve offset = offsets(which == 3 || which == 4);
    const int turn = c_.below(3), flip = c_.below(8);
    for_each_point([&](Vec3& x, std::size_t control_point) {
      Vec3 y;
      for (int k = 0; k < 3; ++k) {
        Real sum = offset[control_point][k];
        for (int j = 0; j < 3; ++j) sum += Real(m(k, j)) * x[j];
        y[k] = static_cast<double>(sum);
        if (y[k] != sum) case_.touch = -1;
      }
      for (int k = 0; k < 3; ++k) x[k] = (flip >> k & 1) ? -y[(k + turn) % 3] : y[(k + turn) % 3];
    });
  }

  void scale() {
    const int how = c_.below(10);
    if (how == 5) scale_by(Vec3::Constant(std::ldexp(1, static_cast<int>(c_.lattice(500)))));
    if (how == 6) {
      scale_by(Vec3::Constant(c_.pick({1e-150, 1e150})));
      case_.touch = -1;
    }
    if (how == 7) {  // the least bit of all coordinates is 2^-10 or more
      const int exponent = static_cast<int>(c_.pick({-1064, -1064, -1070, -1074, -1040}));
      scale_by(Vec3::Constant(0x1p-500));
      scale_by(Vec3::Constant(std::ldexp(1, exponent + 500)));
      if (exponent < -1064) case_.touch = -1;
    }
    if (how == 8) scale_by(Vec3::Constant(c_.pick({0x1p968, 0x1p900, 0x1p600, 0x1p320, 0x1p-330})));
    if (how == 9 && case_.separation == 0) {
      const int most = c_.one_in(8) ? 400 : 40;
      scale_by({std::ldexp(1, static_cast<int>(c_.lattice(most))), std::ldexp(1, static_cast<int>(c_.lattice(most))),
                std::ldexp(1, static_cast<int>(c_.lattice(most)))});
    }
  }

  void round_and_nudge() {
    if (c_.one_in(6)) {  // far from the origin, rounded
      const double size = std::ldexp(1 + c_.below(1 << 20) * 0x1p-20, -c_.below(40));
      const Vec3 offset = c_.pick({1e8, -1e8, 1e5}) * Vec3(1, c_.lattice(1), c_.lattice(1));
      scale_by(Vec3::Constant(size));
      for_each_point([&](Vec3& x, std::size_t) { x += offset; });
      case_.touch = -1;
    }
    if (!c_.one_in(2)) return;
    for (int i = c_.below(3); i >= 0; --i) {
      auto& set = case_.sets[static_cast<std::size_t>(c_.below(2))];
      Curve& p = set[static_cast<std::size_t>(c_.below(static_cast<int>(std::min<std::size_t>(set.size(), 3))))];
      double& x = p[static_cast<std::size_t>(c_.below(case_.control_points))][c_.below(3)];
      const double towards = c_.one_in(2) ? HUGE_VAL : -HUGE_VAL;
      for (int steps = c_.below(3); steps >= 0; --steps) x = std::nextafter(x, towards);
    }
    case_.touch = -1;
  }

  void reorder() {
    const int how = c_.below(6);
    auto& b = case_.sets[1];
    if (how % 2) std::swap(b[0], b[1]);
    if (case_.kind == FeatureKind::vf) std::rotate(b.begin(), b.begin() + how / 2, b.begin() + 3);
    if (case_.kind == FeatureKind::ee && how >= 3) std::swap(case_.sets[0][0], case_.sets[0][1]);
  }

 private:
  /// What lies between the features.
  enum class Between {
    plane,    ///< z = 0, at every control point; they touch in it at the time of contact
    nothing,  ///< in general, they pass through each other
    no_space  ///< they stay in z = 0
  };

  Vec3 lattice(int range) { return {c_.lattice(range), c_.lattice(range), c_.lattice(range)}; }

  Path path() {
    Path p;
    p.x = lattice(range_);
    if (speed_ > 0) p.v = lattice(speed_);
    if (speed_ > 0 && case_.control_points == 3) p.a = lattice(speed_);
    return p;
  }

  /// Where the other feature's contact point is at the time, going on freely, within the plane of d and e (the
  /// coplanarity polynomial has a double root then), or along with it.
  Path meeting(const Path& contact, const Vec3& d, const Vec3& e) {
    Path p = path();
    p.x = contact.x;
    const int how = c_.below(4);
    if (how == 2) p.v = contact.v + c_.lattice(3) * d + c_.lattice(3) * e;
    if (how == 3) p.v = contact.v;
    return p;
  }

  /// `meets`: has a part in the contact.
  void add(std::size_t set, const Path& path, bool meets) {
    Curve p = path.curve(case_.control_points, t_);
    const double side = set == 0 ? 1 : -1;
    for (int k = 0; k < 3; ++k) {
      const bool contact = meets && !(t_ == 0 && k > 0) && !(t_ == 1 && k < case_.control_points - 1);
      double& z = p[static_cast<std::size_t>(k)].z();
      if (between_ == Between::plane) z = contact ? 0 : side * std::abs(c_.lattice(range_));
      if (between_ == Between::no_space) z = 0;
      p[static_cast<std::size_t>(k)] += k * drift_;
    }
    if (case_.control_points == 2) p[2] = p[1];
    case_.sets[set].push_back(p);
  }

  /// Added at each control point. `diagonal`: along x + y + z = const, with sums between two floats, or that cancel.
  Curve offsets(bool diagonal) {
    const auto big = [&](int bits) { return std::ldexp(c_.lattice(1 << 30), bits - 30); };
    Curve by = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    const int how = c_.below(8);
    if (how == 3) by.fill(Vec3(1e8, c_.lattice(1) * 1e8, c_.lattice(1) * 1e8));
    if (how == 4) by.fill({big(38), big(38), big(38)});
    if (how == 5)
      for (Vec3& x : by) x = {big(30), big(30), big(30)};
    if (how == 6 && diagonal) {
      const double x = big(39) + 0x1p-10 * c_.below(1024), y = big(39) + 0x1p-10 * c_.below(1024);
      by.fill({x, y, (0x1p30 + 0x1p6) - x - y});
    }
    if (how == 7 && diagonal) {  // x + y is just beyond 2^53 and rounded, z before it, the sum small
      const double x = std::abs(big(52)) + c_.below(1024), sum = 0x1p53 + 2 * c_.below(8);
      by.fill({x, sum - x, (16 + c_.below(64)) - sum});
    }
    return by;
  }

  template <class Visit>
  void for_each_point(Visit&& visit) {
    for (auto& set : case_.sets)
      for (Curve& p : set)
        for (std::size_t k = 0; k < 3; ++k) visit(p[k], k);
  }
  void scale_by(const Vec3& factors) {
    for_each_point([&](Vec3& x, std::size_t) { x = x.cwiseProduct(factors); });
    case_.separation *= factors.x();
  }

  Choices& c_;
  Case case_;
  int range_, speed_;
  double t_, lift_ = 0;
  Between between_;
  Vec3 drift_;
};

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
  Real least =
      std::min({point_to_edge(p[0], p[1], p[2]), point_to_edge(p[0], p[2], p[3]), point_to_edge(p[0], p[3], p[1])});
  const Point n = cross(p[2] - p[1], p[3] - p[1]);
  const Real square = dot(n, n);
  bool inside = square > 0;
  for (std::size_t i = 1; i <= 3; ++i) inside = inside && dot(cross(p[i % 3 + 1] - p[i], p[0] - p[i]), n) >= 0;
  return inside ? std::min(least, std::abs(dot(n, p[0] - p[1])) / std::sqrt(square)) : least;
}

Real edge_to_edge(const std::array<Point, 4>& p) {
  Real least = std::min({point_to_edge(p[0], p[2], p[3]), point_to_edge(p[1], p[2], p[3]),
                         point_to_edge(p[2], p[0], p[1]), point_to_edge(p[3], p[0], p[1])});
  const Point d = p[1] - p[0], e = p[3] - p[2], r = p[2] - p[0], n = cross(d, e);
  const Real square = dot(n, n);
  if (!(square > 0)) return least;
  const Real s = dot(cross(r, e), n) / square, u = dot(cross(r, d), n) / square;
  return s >= 0 && s <= 1 && u >= 0 && u <= 1 ? std::min(least, std::abs(dot(n, r)) / std::sqrt(square)) : least;
}

}  // namespace

Case near_degenerate(Choices& choices, FeatureKind kind, int control_points, std::size_t first, std::size_t second,
                     Separation separation) {
  Builder builder(choices, kind, control_points);
  if (kind == FeatureKind::vf) builder.vertex_and_triangle();
  if (kind == FeatureKind::ee) builder.two_edges();
  builder.fill(0, first);
  builder.fill(1, second);
  if (separation == Separation::some) builder.move_apart();
  builder.transform();
  builder.scale();
  builder.round_and_nudge();
  builder.reorder();
  return builder.take();
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

double Coordinates::distance(double t) const {
  std::array<Point, 4> p;
  const Real s = 1 - Real(t);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& x = points_[i];
      p[i][k] = control_points_ == 2 ? s * x[k] + t * x[k + 3] : s * (s * x[k] + 2 * t * x[k + 3]) + t * (t * x[k + 6]);
    }
  return static_cast<double>(kind_ == FeatureKind::vf ? vertex_to_triangle(p) : edge_to_edge(p));
}

bool seen_within_separation(const Case& c, double t_max, double* at) {
  const Coordinates x(c);
  constexpr int kSamples = 32;
  double best = 0, least = HUGE_VAL;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = t_max * i / kSamples, distance = x.distance(t);
    if (distance < least) least = distance, best = t;
  }
  double low = std::max(0.0, best - t_max / kSamples), high = std::min(t_max, best + t_max / kSamples);
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (x.distance(a) <= x.distance(b))
      high = b;
    else
      low = a;
  }
  const double near = c.separation * (1 + 1e-6) + 1e-12 * x.size();
  for (const double t : {best, low, high}) {
    if (x.distance(t) > near || compare_distance(x.motion(), t, c.separation) > 0) continue;
    *at = t;
    return true;
  }
  return false;
}

bool touches(const Case& c, double t_max) {
  if (c.touch >= 0 && c.touch <= t_max) return true;
  double at;
  if (c.separation > 0) return seen_within_separation(c, t_max, &at);
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

}  // namespace volccd::test
