#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>

#include <algorithm>
#include <cassert>
#include <limits>

#include <volccd/numerics/odd_parts.hpp>

namespace volccd::detail {
namespace {

bool is_zero(const Curve& v) {
  return std::all_of(v.begin(), v.end(), [](const Polynomial& p) { return p.is_zero(); });
}

constexpr std::array<PointAndEdge, 3> kVertexAndSides = {{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
constexpr std::array<PointAndEdge, 4> kEndsAndEdges = {{{0, 2, 3}, {1, 2, 3}, {2, 0, 1}, {3, 0, 1}}};

/// The motion at one time. The signs of polynomials at this time are computed once.
class Instant {
 public:
  Instant(const std::array<Curve, 4>& x, AlgebraicTime& t) : x_(x), t_(t) {}

  /// An axis along which a x b does not vanish, or -1.
  int axis_of(const Curve& a, const Curve& b) {
    for (std::size_t k = 0; k < 3; ++k)
      if (t_.sign(cross(a, b, k)) != 0) return static_cast<int>(k);
    return -1;
  }

  /// Sign of the area of the triangle of three points in the projection along an axis.
  int side(std::size_t i, std::size_t j, std::size_t k, int axis) {
    return t_.sign(cross(x_[j] - x_[i], x_[k] - x_[i], static_cast<std::size_t>(axis)));
  }

  bool test_point_on_edge(const PointAndEdge& p) {
    const Curve g = x_[p.g] - x_[p.point], h = x_[p.h] - x_[p.point];
    return t_.sign(dot(g, h)) <= 0 && axis_of(g, h) < 0;
  }

  bool test_any_point_on_edge(FeatureKind kind) {
    const auto candidates = points_and_edges(kind);
    return std::any_of(candidates.begin(), candidates.end(),
                       [&](const PointAndEdge& p) { return test_point_on_edge(p); });
  }

 private:
  const std::array<Curve, 4>& x_;
  AlgebraicTime& t_;
};

/// A polynomial that has exactly the common roots of all components. Zero if all components are zero.
Polynomial common_roots(const Curve& v) { return greatest_common_divisor(greatest_common_divisor(v[0], v[1]), v[2]); }

}  // namespace

std::span<const PointAndEdge> points_and_edges(FeatureKind kind) {
  if (kind == FeatureKind::vf) return kVertexAndSides;
  return kEndsAndEdges;
}

void CommonIntegers::add(double x) { values_.push_back(x); }

void CommonIntegers::add(std::span<const double> x) { values_.insert(values_.end(), x.begin(), x.end()); }

std::vector<Integer> CommonIntegers::integers() const {
  int min = std::numeric_limits<int>::max();
  for (const double x : values_)
    if (x != 0) min = std::min(min, odd_parts(x).exponent);
  std::vector<Integer> result(values_.size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] == 0) continue;
    const OddParts p = odd_parts(values_[i]);
    result[i] = p.mantissa;
    result[i] <<= p.exponent - min;
  }
  return result;
}

RelativeCurves relative_curves(const TestMotion& motion, double separation) {
  const auto stride = static_cast<std::size_t>(3 * motion.control_points);
  CommonIntegers coordinates;
  for (const double* x : motion.points) coordinates.add({x, stride});
  coordinates.add(separation);
  const std::vector<Integer> x = coordinates.integers();
  RelativeCurves curves{{}, x.back()};
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto control = [&](std::size_t c) { return Integer(x[i * stride + 3 * c + k] - x[3 * c + k]); };
      const Integer b0 = control(0), b1 = control(1);
      if (motion.control_points == 2) {
        curves.x[i][k] = Polynomial({b0, b1 - b0});
      } else {
        const Integer b2 = control(2);
        curves.x[i][k] = Polynomial({b0, 2 * (b1 - b0), b0 - 2 * b1 + b2});
      }
    }
  return curves;
}

bool coplanar_features_touch(FeatureKind kind, const std::array<Curve, 4>& x, AlgebraicTime& t, bool& degenerate) {
  Instant now(x, t);
  const bool vf = kind == FeatureKind::vf;
  const int axis = vf ? now.axis_of(x[2] - x[1], x[3] - x[1]) : now.axis_of(x[1] - x[0], x[3] - x[2]);
  if (axis < 0) {
    degenerate = true;
    return now.test_any_point_on_edge(kind);
  }
  // In the projection along this axis, the plane of the points is not a line.
  if (vf) {
    const int a = now.side(0, 1, 2, axis), b = now.side(0, 2, 3, axis);
    if (a * b < 0) return false;
    const int c = now.side(0, 3, 1, axis);
    return a * c >= 0 && b * c >= 0;
  }
  return now.side(0, 1, 2, axis) * now.side(0, 1, 3, axis) <= 0 &&
         now.side(2, 3, 0, axis) * now.side(2, 3, 1, axis) <= 0;
}

std::vector<Polynomial> coplanar_events(FeatureKind kind, const std::array<Curve, 4>& x) {
  std::vector<Polynomial> events;
  const auto add = [&](const Curve& v) {
    if (!is_zero(v)) events.push_back(common_roots(v));
  };
  for (const PointAndEdge& p : points_and_edges(kind)) {
    const Curve g = x[p.g] - x[p.point], h = x[p.h] - x[p.point], area = cross(g, h);
    if (!is_zero(area)) {
      add(area);
    } else {
      add(g);
      add(h);
    }
  }
  return events;
}

}  // namespace volccd::detail
