// Distances of features at one time, and overlap of convex hulls, in rational arithmetic.
#include <algorithm>
#include <cassert>

#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>

namespace volccd {
namespace {

using namespace detail;
using IntegerPoint = Vector3<Integer>;

Rational ratio(const Integer& a, const Integer& b) { return Rational(a, b); }

Rational point_edge(const IntegerPoint& p, const IntegerPoint& a, const IntegerPoint& b) {
  const IntegerPoint edge = b - a, q = p - a;
  const Integer along = dot(edge, q), length = dot(edge, edge);
  if (along <= 0) return Rational(dot(q, q));
  if (along >= length) return Rational(dot(IntegerPoint(p - b), IntegerPoint(p - b)));
  const IntegerPoint area = cross(edge, q);
  return ratio(dot(area, area), length);
}

Rational vertex_triangle(const std::array<IntegerPoint, 4>& x) {
  Rational min = std::min({point_edge(x[0], x[1], x[2]), point_edge(x[0], x[2], x[3]), point_edge(x[0], x[3], x[1])});
  const IntegerPoint normal = cross(x[2] - x[1], x[3] - x[1]);
  const Integer square = dot(normal, normal);
  if (square == 0) return min;
  const auto inside = [&](const IntegerPoint& a, const IntegerPoint& b) {
    return dot(normal, cross(b - a, x[0] - a)) >= 0;
  };
  if (!inside(x[1], x[2]) || !inside(x[2], x[3]) || !inside(x[3], x[1])) return min;
  const Integer height = dot(normal, x[0] - x[1]);
  return std::min(min, ratio(height * height, square));
}

Rational edge_edge(const std::array<IntegerPoint, 4>& x) {
  Rational min = std::min({point_edge(x[0], x[2], x[3]), point_edge(x[1], x[2], x[3]), point_edge(x[2], x[0], x[1]),
                           point_edge(x[3], x[0], x[1])});
  const IntegerPoint u = x[1] - x[0], v = x[3] - x[2], r = x[2] - x[0], normal = cross(u, v);
  const Integer square = dot(normal, normal);
  if (square == 0) return min;
  const Integer s = dot(normal, cross(r, v)), w = dot(normal, cross(r, u));
  if (s < 0 || s > square || w < 0 || w > square) return min;
  const Integer height = dot(normal, r);
  return std::min(min, ratio(height * height, square));
}

/// Phase one of the simplex method: whether there is a non-negative x with A x = b. The columns of `tableau` are those
/// of A, followed by b >= 0. Bland's rule prevents cycles.
bool feasible(std::vector<std::vector<Rational>> tableau) {
  const std::size_t rows = tableau.size(), columns = tableau.front().size() - 1;
  // The artificial variables, one per row, are the initial basis; after they have left it they do not return.
  std::vector<std::size_t> basis(rows);
  std::vector<Rational> price(columns + 1);
  for (std::size_t i = 0; i < rows; ++i) {
    basis[i] = columns + i;
    for (std::size_t j = 0; j <= columns; ++j) price[j] += tableau[i][j];
  }
  while (price[columns] != 0) {
    std::size_t enter = 0;
    while (enter < columns && price[enter] <= 0) ++enter;
    if (enter == columns) return false;
    std::size_t leave = rows;
    Rational min;
    for (std::size_t i = 0; i < rows; ++i) {
      if (tableau[i][enter] <= 0) continue;
      const Rational bound = tableau[i][columns] / tableau[i][enter];
      if (leave == rows || bound < min || (bound == min && basis[i] < basis[leave])) {
        leave = i;
        min = bound;
      }
    }
    assert(leave < rows);  // the sum of the artificial variables is bounded from below
    basis[leave] = enter;
    const Rational pivot = tableau[leave][enter];
    for (Rational& value : tableau[leave]) value /= pivot;
    const auto eliminate = [&](std::vector<Rational>& row) {
      const Rational factor = row[enter];
      if (factor == 0) return;
      for (std::size_t j = 0; j <= columns; ++j) row[j] -= factor * tableau[leave][j];
    };
    for (std::size_t i = 0; i < rows; ++i)
      if (i != leave) eliminate(tableau[i]);
    eliminate(price);
  }
  return true;
}

/// Whether all points of one set are beyond all points of the other along an axis.
bool axis_separates(std::span<const Vec3> a, std::span<const Vec3> b) {
  for (int k = 0; k < 3; ++k) {
    const auto less = [k](const Vec3& p, const Vec3& q) { return p[k] < q[k]; };
    const auto [a_min, a_max] = std::minmax_element(a.begin(), a.end(), less);
    const auto [b_min, b_max] = std::minmax_element(b.begin(), b.end(), less);
    if ((*a_max)[k] < (*b_min)[k] || (*b_max)[k] < (*a_min)[k]) return true;
  }
  return false;
}

}  // namespace

int compare_distance(const TestMotion& motion, double t, double d) {
  assert(t >= 0 && t <= 1 && d >= 0);
  const auto degree = static_cast<std::size_t>(motion.control_points - 1), stride = 3 * (degree + 1);
  CommonIntegers numbers;
  for (const double* x : motion.points) numbers.add({x, stride});
  numbers.add(d);
  std::vector<Integer> x = numbers.integers();
  // Numerators of positions over 2^(degree bits), by de Casteljau's algorithm; the same for d.
  const Dyadic time = dyadic(t);
  const Integer rest = (Integer(1) << time.bits) - time.numerator;
  std::array<IntegerPoint, 4> points;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto control = [&](std::size_t c) -> Integer& { return x[i * stride + 3 * c + k]; };
      for (std::size_t left = degree; left > 0; --left)
        for (std::size_t c = 0; c < left; ++c) control(c) = rest * control(c) + time.numerator * control(c + 1);
      points[i][k] = control(0);
    }
  const Integer distance = x.back() << (time.bits * degree);
  const Rational square = motion.kind == FeatureKind::vf ? vertex_triangle(points) : edge_edge(points);
  return Rational(square - Rational(distance * distance)).sign();
}

bool exact_hulls_overlap(std::span<const Vec3> a, std::span<const Vec3> b) {
  if (a.empty() || b.empty() || axis_separates(a, b)) return false;
  CommonIntegers numbers;
  for (const auto& set : {a, b})
    for (const Vec3& p : set) numbers.add({p.data(), 3});
  std::vector<Integer> x = numbers.integers();
  // Weights of the points: the same point must be a mean of both sets. Coordinates are relative to the first point,
  // which keeps numbers short.
  const std::vector<Integer> origin(x.begin(), x.begin() + 3);
  std::vector<std::vector<Rational>> rows(5, std::vector<Rational>(a.size() + b.size() + 1));
  for (std::size_t i = 0; i < a.size() + b.size(); ++i) {
    const bool first = i < a.size();
    for (std::size_t k = 0; k < 3; ++k) {
      const Integer offset = x[3 * i + k] - origin[k];
      rows[k][i] = first ? offset : Integer(-offset);
    }
    rows[first ? 3 : 4][i] = 1;
  }
  rows[3].back() = rows[4].back() = 1;
  return feasible(std::move(rows));
}

}  // namespace volccd
