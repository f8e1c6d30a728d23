// Shells of many parts that share vertices, described by a few large patches and meshed with any edge length.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// A set of patches with four corners. Corners at the same position (to 1e-6 in each coordinate) are identical, and
/// patches share the side between the same two corners, so that the mesh is conforming. Opposite sides of a patch are
/// divided equally.
class QuadComplex {
 public:
  /// Projects a point onto a surface. It must not move points of the surface, because it is applied more than once.
  using Snap = std::function<Vec3(const Vec3&)>;

  /// All vertices of this part's patches will lie on that surface. At a vertex of two such parts, the part whose patch
  /// was added first counts. Must be called before the part's first patch.
  void snap(std::int32_t part, Snap surface);
  /// Adds a patch, whose triangles have the orientation a, b, c, d.
  void patch(std::int32_t part, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
  /// Makes the side from a to b of an existing patch a curve: `curve` maps the vertices of the straight side to their
  /// positions. Throws ConfigError if there is no such side.
  void bend(const Vec3& a, const Vec3& b, Snap curve);

  /// Adds patches between consecutive sections, which are closed loops with the same number of corners.
  void tube(std::int32_t part, const std::vector<std::vector<Vec3>>& sections);
  /// Adds the patches of a grid whose corners are at place(u, v).
  void grid(std::int32_t part, const std::vector<double>& u, const std::vector<double>& v,
            const std::function<Vec3(double, double)>& place);

  /// Number of triangles of the mesh with edges about as long as `spacing`. O(patches).
  std::int64_t triangle_count(double spacing) const;
  /// The spacing that gives about this number of triangles. Throws ConfigError for fewer than two for each patch.
  double spacing_for(std::int64_t triangles) const;
  /// The mesh of triangles, with the part as object. Sides are divided evenly, and positions inside a patch are
  /// interpolated from its sides (Coons). All vertices are used. Deterministic.
  Shape mesh(double spacing) const;

 private:
  struct Side {
    Index a, b;  ///< corners, a < b
    std::int32_t snapped_by = -1;
    Snap curve;
  };
  struct Patch {
    std::int32_t part;
    std::array<Index, 4> corners, sides;
  };
  struct Vertices;

  Index corner(const Vec3& p, std::int32_t snapped_by);
  Index side(Index a, Index b, std::int32_t snapped_by);
  Vec3 on_surface(std::int32_t part, const Vec3& p) const;
  std::vector<int> divisions(double spacing) const;
  void place_sides(const std::vector<int>& divisions, Vertices& vertices, Shape& shape) const;
  void fill(const Patch& patch, const std::vector<int>& divisions, const Vertices& vertices, Shape& shape) const;

  std::vector<Vec3> corners_;
  std::vector<std::int32_t> corner_snapped_by_;
  std::map<std::array<std::int64_t, 3>, Index> corner_at_;
  std::vector<Side> sides_;
  std::map<std::pair<Index, Index>, Index> side_between_;
  std::vector<Patch> patches_;
  std::map<std::int32_t, Snap> snaps_;
};

}  // namespace volccd
