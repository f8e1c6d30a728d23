// The simplex of the Gilbert-Johnson-Keerthi algorithm in any ordered ring, for example doubles or integers.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include <volccd/numerics/vector3.hpp>

namespace volccd::detail {

/// At most four points, each identified by a pair of vertices, and the point of their convex hull that is nearest to
/// the origin. Stores the smallest face that contains this point; add() removes all other points.
///
/// With integers everything is exact. With doubles the face may be wrong and the weights are rounded; a caller must
/// prove its conclusions from `points`, `weights` and `direction` itself.
template <class Number>
struct HullSimplex {
  using Point = Vector3<Number>;

  int size = 0;
  std::array<Point, 4> points;
  std::array<std::pair<int, int>, 4> names;
  std::array<Number, 4> weights;  ///< positive; the nearest point is the mean of `points` with these weights
  Point direction;  ///< a positive multiple of the nearest point, or, if that is the origin, 0 or a normal of the face
  Number square{}, divisor{};  ///< squared distance from the origin = square / divisor, divisor > 0

  /// Adds a point. Returns false, without a change, if the convex hull of all points contains no point nearer to the
  /// origin than before.
  bool add(const Point& point, std::pair<int, int> name) {
    HullSimplex best;
    const auto offer = [&](const std::array<int, 3>& with, int count) {
      HullSimplex face;
      face.size = count + 1;
      for (int i = 0; i < count; ++i) face.set_point(i, points[at(with[at(i)])], names[at(with[at(i)])]);
      face.set_point(count, point, name);
      if (face.project() && (best.size == 0 || face.nearer_than(best))) best = std::move(face);
    };
    offer({}, 0);
    for (int i = 0; i < size; ++i) offer({i}, 1);
    for (int i = 0; i < size; ++i)
      for (int j = i + 1; j < size; ++j) offer({i, j}, 2);
    if (size == 3) offer({0, 1, 2}, 3);
    if (best.size == 0 || (size > 0 && !best.nearer_than(*this))) return false;
    *this = std::move(best);
    return true;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void set_point(int i, const Point& point, std::pair<int, int> name) {
    points[at(i)] = point;
    names[at(i)] = name;
  }

  bool nearer_than(const HullSimplex& other) const { return square * other.divisor < other.square * divisor; }

  /// Projects the origin onto the affine hull. Returns false if the points are dependent, or the projection is not
  /// inside.
  bool project() {
    switch (size) {
      case 1: return project_point();
      case 2: return project_segment();
      case 3: return project_triangle();
      default: return project_tetrahedron();
    }
  }

  bool project_point() {
    weights[0] = Number(1);
    direction = points[0];
    square = dot(points[0], points[0]);
    divisor = Number(1);
    return true;
  }

  bool project_segment() {
    const Point &p = points[0], &q = points[1], e = q - p;
    weights[0] = dot(q, e);
    weights[1] = -dot(p, e);
    if (!(weights[0] > 0 && weights[1] > 0)) return false;
    // |e|^2 times the component of p perpendicular to e; this form is accurate for small distances.
    const Point moment = cross(p, e);
    direction = cross(e, moment);
    square = dot(moment, moment);
    divisor = dot(e, e);
    return true;
  }

  bool project_triangle() {
    const Point &p = points[0], &q = points[1], &r = points[2];
    direction = cross(Point(q - p), Point(r - p));
    weights[0] = dot(direction, cross(q, r));
    weights[1] = dot(direction, cross(r, p));
    weights[2] = dot(direction, cross(p, q));
    if (!(weights[0] > 0 && weights[1] > 0 && weights[2] > 0)) return false;
    const Number height = dot(direction, p);
    if (height < 0) direction = -direction;
    square = height * height;
    divisor = dot(direction, direction);
    return true;
  }

  bool project_tetrahedron() {
    const Point &p = points[0], &q = points[1], &r = points[2], &s = points[3];
    const Point rs = cross(r, s), pq = cross(p, q);
    weights = {dot(q, rs), Number(-dot(p, rs)), dot(s, pq), Number(-dot(r, pq))};
    if (weights[0] < 0)
      for (Number& w : weights) w = -w;
    for (const Number& w : weights)
      if (!(w > 0)) return false;
    direction = {Number(0), Number(0), Number(0)};
    square = Number(0);
    divisor = Number(1);
    return true;
  }
};

}  // namespace volccd::detail
