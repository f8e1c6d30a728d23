// The orientation of the elements in `cases`, compared with VTK's documentation of its cells.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <volccd/mesh/shells.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

/// Six times the signed volume of the tetrahedron; positive where a, b, c turn left as seen from d.
double turn(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// Whether a convex element has VTK's node order. As seen from the opposite nodes, the base of a tetrahedron, a pyramid
/// and a hexahedron is counter-clockwise, and that of a wedge clockwise. Faces of polytopes have no orientation.
bool has_vtk_order(const ElementSpec& element, std::span<const Vec3> x) {
  const auto at = [&](std::size_t i) { return x[element.vertices[i]]; };
  const auto base_turn = [&](std::size_t opposite) { return turn(at(0), at(1), at(2), at(opposite)); };
  switch (element.type) {
    case ElementType::tetrahedron: return base_turn(3) > 0;
    case ElementType::pyramid: return base_turn(4) > 0 && turn(at(0), at(2), at(3), at(4)) > 0;
    case ElementType::hexahedron: return base_turn(4) > 0 && turn(at(0), at(2), at(3), at(7)) > 0;
    case ElementType::wedge: return base_turn(3) < 0 && base_turn(5) < 0 && turn(at(3), at(4), at(5), at(0)) > 0;
    default: return true;
  }
}

void expect_vtk_order(const Shape& shape) {
  for (const ElementSpec& element : shape.elements)
    EXPECT_TRUE(has_vtk_order(element, shape.positions)) << to_string(element.type) << " " << element.id;
}

TEST(Shapes, ElementsHaveThePositiveVolumeOfVtk) {
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron})
    expect_vtk_order(block(type, 2, 3, 2));
  expect_vtk_order(mixed_block(2, 2));
  expect_vtk_order(permuted(mixed_block(2, 1), 3));
}

TEST(Shapes, ThickenedShellsHaveThePositiveVolumeOfVtk) {
  for (const ElementType type : {ElementType::triangle, ElementType::quad}) {
    Shape sheet = block(type, 3, 2, 1);
    // One shell has the opposite orientation; the thickener makes all orientations equal.
    std::swap(sheet.elements[1].vertices[0], sheet.elements[1].vertices[2]);
    const Mesh mesh = sheet.mesh();
    const ShellThickener thickener(mesh);
    const Mesh solids = thickener.solid_mesh(mesh);
    const std::vector<double> thickness(mesh.element_slots(), 0.25);
    std::vector<Vec3> positions;
    thickener.positions(sheet.positions, thickness, positions);
    for (Index o = 0; o < solids.element_slots(); ++o) {
      const auto vertices = solids.vertices(o);
      EXPECT_TRUE(has_vtk_order({solids.type(o), {vertices.begin(), vertices.end()}, {}, 0, 0}, positions)) << o;
    }
  }
}

}  // namespace
}  // namespace volccd
