// Rigid tools of tetrahedra.
#pragma once

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// A hexagonal funnel around the z axis, open above: six plane walls, whose inner sides have the distance `depth` from
/// the origin and face it, with unit normals (sin slope cos a, sin slope sin a, cos slope) for a = 0, 60, .. degrees.
/// They reach from their common point below the origin to the plane z = 0.
struct FunnelShape {
  double depth = 0.25, slope = 0.85;
  double thickness = 0.02;  ///< of the walls, along their normals
  int rings = 10;           ///< of triangles, from the lowest point to the rim

  int elements() const { return 18 * rings * rings; }
};

/// One layer of prisms over triangles, each of three tetrahedra with positive volume. Object 0; conforming.
/// Deterministic. Throws ConfigError for sizes or numbers that are not positive, or a slope outside (0, pi / 2).
Shape funnel(const FunnelShape& funnel);

/// A knife in the plane y = 0: its edge is the segment |x| <= width / 2 on the x axis, its back the plane z = -height.
/// From the edge to z = -bevel the thickness grows evenly from zero, and is constant below.
struct KnifeShape {
  double width = 0.2, height = 0.1, thickness = 0.004, bevel = 0.02;
  int along = 8, down = 4;  ///< cells

  int elements() const { return along * (6 * (down - 1) + 3); }
};

/// Tetrahedra with positive volume in one layer of cells, the first row at the bevel. Object 0; conforming.
/// Deterministic. Throws ConfigError for sizes or numbers that are not positive, bevel >= height, or down < 2.
Shape knife(const KnifeShape& knife);

}  // namespace volccd
