// The simplex of the Gilbert-Johnson-Keerthi algorithm: at most four points of a convex set, and the direction from the
// origin to the nearest point of their convex hull.
#pragma once

#include <array>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Rounding errors affect only the quality of the direction; a caller that uses it as an axis must test the axis
/// itself.
class CsatSimplex {
 public:
  void clear() { size_ = 0; }
  bool contains(const Vec3& p) const;
  void add(const Vec3& p) { points_[static_cast<std::size_t>(size_++)] = p; }

  /// Reduces the simplex to the face nearest to the origin, and sets `direction` to a positive multiple of the nearest
  /// point of that face, computed so that small distances are accurate. Returns false, with `direction` undefined, if
  /// the origin is inside the simplex (or on its boundary, within rounding errors).
  bool nearest(Vec3& direction);

 private:
  bool segment(Vec3& direction);
  bool triangle(Vec3& direction);
  bool tetrahedron(Vec3& direction);
  void keep(int i);
  void keep(int i, int j);

  int size_ = 0;
  std::array<Vec3, 4> points_;
};

}  // namespace volccd::detail
