#include <volccd/numerics/gjk_simplex.hpp>

#include <limits>

#include <Eigen/Geometry>

namespace volccd::detail {

void GjkSimplex::keep(std::initializer_list<std::size_t> indices) {
  size_ = 0;
  for (const std::size_t i : indices) add(points_[i]);
}

bool GjkSimplex::reduce(Vec3& direction) {
  switch (size_) {
    case 1: direction = points_[0]; return direction.squaredNorm() > 0;
    case 2: return reduce_segment(direction);
    case 3: return reduce_triangle(direction);
    default: return reduce_tetrahedron(direction);
  }
}

bool GjkSimplex::reduce_segment(Vec3& direction) {
  const Vec3 &a = points_[0], &b = points_[1], ab = b - a;
  if (!(a.dot(ab) < 0)) {
    keep({0});
  } else if (!(b.dot(ab) > 0)) {
    keep({1});
  } else {
    direction = ab.cross(a.cross(ab));  // |ab|^2 times the component of a perpendicular to ab
    return direction.squaredNorm() > 0;
  }
  return reduce(direction);
}

// Voronoi regions of a triangle (Ericson, Real-Time Collision Detection, 5.1.5), with the origin as the query point.
bool GjkSimplex::reduce_triangle(Vec3& direction) {
  const Vec3 a = points_[0], b = points_[1], c = points_[2];
  const Vec3 ab = b - a, ac = c - a, n = ab.cross(ac);
  const double d1 = -ab.dot(a), d2 = -ac.dot(a), d3 = -ab.dot(b), d4 = -ac.dot(b), d5 = -ab.dot(c), d6 = -ac.dot(c);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (d1 <= 0 && d2 <= 0) {
    keep({0});
  } else if (d3 >= 0 && d4 <= d3) {
    keep({1});
  } else if (d6 >= 0 && d5 <= d6) {
    keep({2});
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    keep({0, 1});
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    keep({0, 2});
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    keep({1, 2});
  } else {
    const double height = n.dot(a);
    direction = height < 0 ? Vec3(-n) : n;
    return height != 0;
  }
  return reduce(direction);
}

// Finds the nearest of the faces that have the origin on their outer side; if there is none, the origin is inside. Flat
// tetrahedra are common when two control points differ by a common translation; for these every face is tested, because
// rounding errors determine their inner side.
bool GjkSimplex::reduce_tetrahedron(Vec3& direction) {
  constexpr std::size_t faces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  GjkSimplex best;
  double best_square = std::numeric_limits<double>::infinity();
  for (const auto& f : faces) {
    const Vec3 &p = points_[f[0]], &q = points_[f[1]], &r = points_[f[2]], &opposite = points_[f[3]];
    const Vec3 n = (q - p).cross(r - p);
    const double origin_side = -n.dot(p), opposite_side = n.dot(opposite - p);
    constexpr double flat = 1e-10;  // relative to the size of the set, which is about 1
    if (origin_side * opposite_side > 0 && opposite_side * opposite_side > flat * flat * n.squaredNorm()) continue;
    GjkSimplex face;
    face.size_ = 3;
    face.points_ = {p, q, r, r};
    Vec3 d;
    if (!face.reduce_triangle(d)) continue;
    const double along = d.dot(face.points_[0]);
    const double square = along * along / d.squaredNorm();
    if (!(square < best_square)) continue;
    best_square = square;
    best = face;
    direction = d;
  }
  if (best.size_ == 0) return false;
  *this = best;
  return true;
}

}  // namespace volccd::detail
