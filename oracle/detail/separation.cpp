#include <volccd/oracle/detail/separation.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace volccd::detail {

namespace {

double gap_along(const Vec3& axis, const ConvexPiece& a, const ConvexPiece& b, const Vec3& centre) {
  const double length = axis.norm();
  if (!(length > 0) || !std::isfinite(length)) return -INFINITY;
  const auto interval = [&](const ConvexPiece& piece) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3& p : piece.span()) {
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

}  // namespace

double signed_gap(const ConvexPiece& a, const ConvexPiece& b) {
  const Vec3 centre = (a.points[0] + b.points[0]) / 2;
  double best = -INFINITY;
  const auto take = [&](const Vec3& axis) { best = std::max(best, gap_along(axis, a, b, centre)); };
  std::array<std::array<Vec3, 6>, 2> edges;
  std::array<int, 2> edge_count = {0, 0};
  for (int c = 0; c < 3; ++c) take(Vec3::Unit(c));
  for (const ConvexPiece* piece : {&a, &b}) {
    const std::size_t which = piece == &a ? 0 : 1;
    const auto& p = piece->points;
    const auto n = static_cast<std::size_t>(piece->count);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        edges[which][static_cast<std::size_t>(edge_count[which]++)] = (p[j] - p[i]).normalized();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        for (std::size_t k = j + 1; k < n; ++k) {
          const Vec3 normal = (p[j] - p[i]).normalized().cross((p[k] - p[i]).normalized());
          take(normal);
          // Within the plane of a triangle: needed where both pieces are flat and lie in it.
          for (const Vec3& e : {Vec3(p[j] - p[i]), Vec3(p[k] - p[i]), Vec3(p[k] - p[j])})
            take(normal.cross(e.normalized()));
        }
  }
  for (int i = 0; i < edge_count[0]; ++i)
    for (int j = 0; j < edge_count[1]; ++j)
      take(edges[0][static_cast<std::size_t>(i)].cross(edges[1][static_cast<std::size_t>(j)]));
  return best;
}

}  // namespace volccd::detail
