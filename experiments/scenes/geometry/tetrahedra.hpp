// Tetrahedra that fill an implicit solid.
#pragma once

#include <volccd/experiments/scenes/geometry/implicit_solid.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Fills the solid with tetrahedra of about the given edge length: isosurface stuffing (Labelle and Shewchuk 2007) of a
/// body-centred cubic lattice whose long edges have length `edge` and whose short ones 0.87 of it, then a few rounds of
/// moving vertices (those of the surface along it) where that makes the flattest tetrahedron around them less flat.
///
/// All tetrahedra have positive volume in VTK's node order. The mesh is conforming and connected through faces (of
/// several pieces, the largest is kept; parts thinner than 1.2 edges may break off or be lost).
/// tests/experiments/scenes/tetrahedra_test.cpp checks that the dihedral angles for a ball are between 18 and 150
/// degrees. Vertices of the surface lie on it up to about 1e-3 edges; where the solid is thinner than two edges, up to
/// a third of an edge outside. Element ids 0, 1, 2, ..; object 0. Deterministic. Time about the box's volume over
/// edge^3.
///
/// Throws ConfigError if `edge` is not positive, the box has more than 10^7 lattice cells, or no tetrahedron is inside.
Shape fill_with_tetrahedra(const ImplicitSolid& solid, double edge);

/// The same with an edge length for which the number of tetrahedra is near `elements`, found by a short search: within
/// 3 % from a few hundred tetrahedra on, usually within 1 %. Also throws ConfigError if elements < 1. The edge length
/// is written to `edge` if that is not null.
Shape fill_with_about(const ImplicitSolid& solid, int elements, double* edge = nullptr);

}  // namespace volccd
