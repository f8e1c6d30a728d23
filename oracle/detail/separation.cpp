#include <volccd/oracle/detail/separation.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace volccd::detail {

namespace {

double gap_along(const Vec3& axis, std::span<const Vec3> a, std::span<const Vec3> b, const Vec3& centre) {
  const double length = axis.norm();
  if (!(length > 0) || !std::isfinite(length)) return -INFINITY;
  const auto interval = [&](std::span<const Vec3> points) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3& p : points) {
      const double h = axis.dot(p - centre);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    return std::pair(low, high);
  };
  const auto [low_a, high_a] = interval(a);
  const auto [low_b, high_b] = interval(b);
  return std::max(low_a - high_b, low_b - high_a) / length;
}

/// Calls visit(axis) for the normals of all triangles of points, and for the normals of their edges within their
/// planes, which are needed if both sets are flat and lie in one plane. Appends the directions of all edges.
template <class Visit>
void visit_axes(std::span<const Vec3> p, std::vector<Vec3>& edges, Visit&& visit) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) edges.push_back((p[j] - p[i]).normalized());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        const Vec3 normal = (p[j] - p[i]).normalized().cross((p[k] - p[i]).normalized());
        visit(normal);
        for (const Vec3& e : {Vec3(p[j] - p[i]), Vec3(p[k] - p[i]), Vec3(p[k] - p[j])})
          visit(normal.cross(e.normalized()));
      }
}

}  // namespace

double signed_gap(const ConvexPiece& a, const ConvexPiece& b) { return signed_gap(a.span(), b.span()); }

double signed_gap(std::span<const Vec3> a, std::span<const Vec3> b) {
  const Vec3 centre = (a[0] + b[0]) / 2;
  double best = -INFINITY;
  const auto visit = [&](const Vec3& axis) { best = std::max(best, gap_along(axis, a, b, centre)); };
  for (int c = 0; c < 3; ++c) visit(Vec3::Unit(c));
  std::vector<Vec3> edges_a, edges_b;
  visit_axes(a, edges_a, visit);
  visit_axes(b, edges_b, visit);
  for (const Vec3& e : edges_a)
    for (const Vec3& f : edges_b) visit(e.cross(f));
  return best;
}

}  // namespace volccd::detail
