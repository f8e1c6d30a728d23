// A bullet and a plate of hexahedra.
#pragma once

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// A cylinder along z with a rounded nose that points to -z, its tip at the origin. The cross-section is a square core
/// of core x core cells within `rings` rings of 4 core cells, so that no hexahedron is degenerate.
struct BulletShape {
  double diameter = 0.010, length = 0.024;
  double nose = 0.009;  ///< length of the rounded part
  int core = 6, rings = 3, layers = 20;

  int elements() const { return core * (core + 4 * rings) * layers; }
};

/// All Jacobians positive. Throws ConfigError for sizes or numbers that are not positive, or a nose longer than the
/// bullet.
Shape round_nosed_bullet(const BulletShape& bullet);

/// A block centred at the origin in x and y, its top at z = 0, of cells[0] x cells[1] x cells[2] hexahedra: of equal
/// width in the middle, |x|, |y| < fine / 2, growing geometrically from there to the rim. About two thirds of the cells
/// are in the middle.
struct PlateShape {
  double side = 0.1, thickness = 0.005;
  double fine = 0.030;
  int cells[3] = {40, 40, 6};

  int elements() const { return cells[0] * cells[1] * cells[2]; }
};

/// All Jacobians positive. Throws ConfigError: sizes not positive, fine >= side, fewer than four cells along x or y or
/// one in z.
Shape graded_plate(const PlateShape& plate);

}  // namespace volccd
