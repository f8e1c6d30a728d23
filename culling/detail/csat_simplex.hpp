// The simplex of a Gilbert-Johnson-Keerthi iteration: at most four points of a convex set, and the direction from the
// origin to the nearest point of their hull.
#pragma once

#include <array>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Rounding can only spoil the direction's quality: who uses it as an axis checks the axis by itself.
class CsatSimplex {
 public:
  void clear() { size_ = 0; }
  bool contains(const Vec3& p) const;
  void add(const Vec3& p) { points_[static_cast<std::size_t>(size_++)] = p; }

  /// Cuts the simplex down to the face nearest to the origin and sets `direction` to a positive multiple of that face's
  /// nearest point, computed so that a short distance keeps its digits. Returns false, with `direction` undefined, if
  /// the origin is inside (or on it, within rounding).
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
