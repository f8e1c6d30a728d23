#include <volccd/oracle/cases/contact_builder.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace volccd::cases {

Curve Path::curve(int control_points, double t) const {
  const Vec3 start = x - t * v + t * t * a, end = x + (1 - t) * v + (1 - t) * (1 - t) * a;
  if (control_points == 2) return {start, end, end};
  return {start, x + (0.5 - t) * v + (t * t - t) * a, end};
}

ContactBuilder::ContactBuilder(Choices& choices, FeatureKind kind, int control_points, std::optional<double> time)
    : c_(choices) {
  case_.kind = kind;
  case_.control_points = control_points;
  range_ = static_cast<int>(c_.pick({1, 2, 5, 16, 1000, 1 << 18}));
  speed_ = static_cast<int>(c_.pick({0, 1, 1, 16, 1000, 1 << 18}));
  case_.touch = t_ = time ? *time : c_.pick({0, 1, 0.5, 0.25, 0.75, 0.125});
  between_ = static_cast<Between>(c_.below(3));
  drift_ = c_.one_in(2) ? lattice(1 << 18) : Vec3(Vec3::Zero());
}

void ContactBuilder::vertex_and_triangle(Shape kind) {
  Path b[3] = {path(), path(), path()};
  const int shape = choose(kind);
  if (shape == 5) b[2] = b[1];
  if (shape == 6) b[1] = b[2] = b[0];
  if (shape == 7) b[2] = 2.0 * b[1] + -1.0 * b[0];
  double w[3] = {1, 0, 0};
  const int place = kind == Shape::general ? 3 : c_.below(3);
  if (place == 1) w[0] = 0.5, w[1] = 0.5;
  if (place == 2) {
    w[0] = c_.below(17) / 16.0;
    w[1] = c_.below(static_cast<int>(16 * (1 - w[0])) + 1) / 16.0;
    w[2] = 1 - w[0] - w[1];
  }
  if (place == 3) {
    w[0] = (1 + c_.below(14)) / 16.0;
    w[1] = (1 + c_.below(static_cast<int>(15 - 16 * w[0]))) / 16.0;
    w[2] = 1 - w[0] - w[1];
  }
  const Path contact = w[0] * b[0] + w[1] * b[1] + w[2] * b[2];
  add(0, meeting(contact, b[1].x - b[0].x, b[2].x - b[0].x, kind), true);
  for (int i = 0; i < 3; ++i) add(1, b[i], w[i] > 0);
}

void ContactBuilder::two_edges(Shape kind) {
  Path a[2] = {path(), path()}, b[2] = {path(), {}};
  const int shape = choose(kind);
  if (shape == 7) a[1] = a[0];
  const bool within = kind == Shape::general;
  const double s = within ? c_.pick({0.5, 0.25, 0.0625, 0.9375}) : c_.pick({0, 1, 0.5, 0.25, 0.0625, 0.9375});
  const double u = within ? c_.pick({0.5, 0.25, 0.0625}) : c_.pick({1, 0.5, 0.25, 0.0625});
  const Path contact = (1 - s) * a[0] + s * a[1];
  if (shape == 5) b[0] = contact;
  if (shape == 6) b[0].x = contact.x + c_.lattice(3) * (a[1].x - a[0].x);
  b[1] = (1 / u) * (meeting(contact, a[1].x - a[0].x, contact.x - b[0].x, kind) + (u - 1) * b[0]);
  add(0, a[0], s < 1);
  add(0, a[1], s > 0);
  add(1, b[0], u < 1);
  add(1, b[1], true);
}

void ContactBuilder::fill(std::size_t set, std::size_t count) {
  while (case_.sets[set].size() < count) add(set, path(), false);
}

void ContactBuilder::move_apart() {
  lift_ = c_.pick({1, 2, 0.5, 16, 0.0009765625, 1 << 18});
  case_.separation = lift_;
  for (Curve& p : case_.sets[0])
    for (Vec3& x : p) x.z() += lift_;
}

void ContactBuilder::transform() {
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
      long double sum = offset[control_point][k];
      for (int j = 0; j < 3; ++j) sum += static_cast<long double>(m(k, j)) * x[j];
      y[k] = static_cast<double>(sum);
      if (y[k] != sum) case_.touch = -1;
    }
    for (int k = 0; k < 3; ++k) x[k] = (flip >> k & 1) ? -y[(k + turn) % 3] : y[(k + turn) % 3];
  });
}

void ContactBuilder::scale() {
  const int how = c_.below(10);
  if (how == 5) scale_by(Vec3::Constant(std::ldexp(1, static_cast<int>(c_.lattice(500)))));
  if (how == 6) {
    scale_by(Vec3::Constant(c_.pick({1e-150, 1e150})));
    case_.touch = -1;
  }
  if (how == 7) {  // the lowest bit of all coordinates is 2^-10 or higher
    const int exponent = static_cast<int>(c_.pick({-1064, -1064, -1070, -1074, -1040}));
    scale_by(Vec3::Constant(0x1p-500));
    scale_by(Vec3::Constant(std::ldexp(1, exponent + 500)));
    if (exponent < -1064) case_.touch = -1;
  }
  if (how == 8) scale_by(Vec3::Constant(c_.pick({0x1p968, 0x1p900, 0x1p600, 0x1p320, 0x1p-330})));
  if (how == 9 && case_.separation == 0) {
    const int max = c_.one_in(8) ? 400 : 40;
    scale_by({std::ldexp(1, static_cast<int>(c_.lattice(max))), std::ldexp(1, static_cast<int>(c_.lattice(max))),
              std::ldexp(1, static_cast<int>(c_.lattice(max)))});
  }
}

void ContactBuilder::move_far() {
  const double size = std::ldexp(1 + c_.below(1 << 20) * 0x1p-20, -c_.below(40));
  const Vec3 offset = c_.pick({1e8, -1e8, 1e5}) * Vec3(1, c_.lattice(1), c_.lattice(1));
  scale_by(Vec3::Constant(size));
  for_each_point([&](Vec3& x, std::size_t) { x += offset; });
  case_.touch = -1;
}

void ContactBuilder::nudge() {
  for (int i = c_.below(3); i >= 0; --i) {
    auto& set = case_.sets[static_cast<std::size_t>(c_.below(2))];
    Curve& p = set[static_cast<std::size_t>(c_.below(static_cast<int>(std::min<std::size_t>(set.size(), 3))))];
    double& x = p[static_cast<std::size_t>(c_.below(case_.control_points))][c_.below(3)];
    const double towards = c_.one_in(2) ? HUGE_VAL : -HUGE_VAL;
    for (int steps = c_.below(3); steps >= 0; --steps) x = std::nextafter(x, towards);
  }
  case_.touch = -1;
}

void ContactBuilder::round_and_nudge() {
  if (c_.one_in(6)) move_far();
  if (c_.one_in(2)) nudge();
}

void ContactBuilder::reorder() {
  const int how = c_.below(6);
  auto& b = case_.sets[1];
  if (how % 2) std::swap(b[0], b[1]);
  if (case_.kind == FeatureKind::vf) std::rotate(b.begin(), b.begin() + how / 2, b.begin() + 3);
  if (case_.kind == FeatureKind::ee && how >= 3) std::swap(case_.sets[0][0], case_.sets[0][1]);
}

Path ContactBuilder::path() {
  Path p;
  p.x = lattice(range_);
  if (speed_ > 0) p.v = lattice(speed_);
  if (speed_ > 0 && case_.control_points == 3) p.a = lattice(speed_);
  return p;
}

/// The position of the other feature's contact point at that time: moving freely, within the plane of d and e (then the
/// coplanarity polynomial has a double root), or along with this point.
Path ContactBuilder::meeting(const Path& contact, const Vec3& d, const Vec3& e, Shape shape) {
  Path p = path();
  p.x = contact.x;
  const int how = shape == Shape::general ? 0 : c_.below(4);
  if (how == 2) p.v = contact.v + c_.lattice(3) * d + c_.lattice(3) * e;
  if (how == 3) p.v = contact.v;
  return p;
}

/// `meets`: whether the point is part of the contact.
void ContactBuilder::add(std::size_t set, const Path& path, bool meets) {
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

/// An offset at each control point. `diagonal`: along x + y + z = const, where sums lie between two floats or cancel.
Curve ContactBuilder::offsets(bool diagonal) {
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
  // x + y is just above 2^53 and therefore rounded, if z is not added before; the sum is small
  if (how == 7 && diagonal) {
    const double x = std::abs(big(52)) + c_.below(1024), sum = 0x1p53 + 2 * c_.below(8);
    by.fill({x, sum - x, (16 + c_.below(64)) - sum});
  }
  return by;
}

void ContactBuilder::scale_by(const Vec3& factors) {
  for_each_point([&](Vec3& x, std::size_t) { x = x.cwiseProduct(factors); });
  case_.separation *= factors.x();
}

}  // namespace volccd::cases
