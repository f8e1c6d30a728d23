// Shells of many parts, joined by shared vertices: described by a few large patches, meshed as finely as wanted.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Patches with four corners. Corners at the same place (to 1e-6 in each coordinate) are one, a side between the same
/// two corners is one side, of as many patches as have it; the mesh conforms there. Opposite sides of a patch are
/// divided alike.
class QuadComplex {
 public:
  /// Puts a point onto a surface. Must leave points of the surface where they are: it is applied more than once.
  using Snap = std::function<Vec3(const Vec3&)>;

  /// All vertices of this part's patches will lie on that surface; of two such parts at one vertex, the one whose patch
  /// came first. To be set before the part's first patch.
  void snap(std::int32_t part, Snap surface);
  /// A patch; its triangles are numbered in the sense a, b, c, d.
  void patch(std::int32_t part, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
  /// The side from a to b of a patch that is there is a curve: its vertices go where `curve` puts those of the straight
  /// side. Throws ConfigError without such a side.
  void bend(const Vec3& a, const Vec3& b, Snap curve);

  /// Patches for all sections but the last: each is a closed loop of the same number of corners, joined to the next.
  void tube(std::int32_t part, const std::vector<std::vector<Vec3>>& sections);
  /// Patches of a grid of lines whose crossings are at place(u, v).
  void grid(std::int32_t part, const std::vector<double>& u, const std::vector<double>& v,
            const std::function<Vec3(double, double)>& place);

  /// Triangles of the mesh whose edges are about as long as `spacing`. O(patches).
  std::int64_t triangle_count(double spacing) const;
  /// The spacing that comes nearest to this number of triangles. Throws ConfigError: fewer than two a patch.
  double spacing_for(std::int64_t triangles) const;
  /// Triangles, the part as object, sides divided evenly, places inside a patch interpolated from its sides (Coons).
  /// All vertices are used. Deterministic.
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
