// The simplex of the Gilbert-Johnson-Keerthi algorithm: at most four points of a convex set, and the direction from the
// origin to the nearest point of their convex hull.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>

#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// Rounding errors affect only the quality of the direction; a caller that uses it as an axis must test the axis
/// itself.
class GjkSimplex {
 public:
  bool contains(const Vec3& p) const {
    return std::find(points_.begin(), points_.begin() + size_, p) != points_.begin() + size_;
  }
  void add(const Vec3& p) { points_[size_++] = p; }

  /// Reduces the simplex to the face nearest to the origin, and sets `direction` to a positive multiple of the nearest
  /// point of that face, computed so that small distances are accurate. Returns false, with `direction` undefined, if
  /// the origin is inside the simplex (or on its boundary, within rounding errors).
  bool reduce(Vec3& direction);

 private:
  bool reduce_segment(Vec3& direction);
  bool reduce_triangle(Vec3& direction);
  bool reduce_tetrahedron(Vec3& direction);
  /// Removes the points without these indices, which ascend.
  void keep(std::initializer_list<std::size_t> indices);

  std::size_t size_ = 0;
  std::array<Vec3, 4> points_;
};

}  // namespace volccd::detail
