#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/element_type.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "support/allocations.hpp"

namespace volccd {
namespace {

/// Volume enclosed by the faces of a fixed type (divergence theorem on a fan); positive for VTK's node order.
double volume(const Mesh& mesh, Index o, const std::vector<Vec3>& x) {
  double six_volumes = 0;
  const auto v = mesh.vertices(o);
  const auto faces = face_stream(mesh.type(o));
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + 1u)
    for (std::size_t i = 2; i < faces[at]; ++i)
      six_volumes += x[v[faces[at + 1]]].dot(x[v[faces[at + i]]].cross(x[v[faces[at + i + 1]]]));
  return six_volumes / 6;
}

/// Every second element has the opposite orientation.
Shape turned(Shape shape) {
  for (std::size_t i = 0; i < shape.elements.size(); i += 2)
    std::reverse(shape.elements[i].vertices.begin(), shape.elements[i].vertices.end());
  return shape;
}

TEST(Shells, SameBitsForAnyNumberOfWorkers) {
  Shape shape = turned(block(ElementType::triangle, 120, 90, 0));  // several chunks
  Random random(3);
  for (Vec3& p : shape.positions)
    for (int k = 0; k < 3; ++k) p[k] += random.uniform(-0.3, 0.3);
  shape.positions[40] = shape.positions[41] = shape.positions[161];  // shells without area
  const Mesh mesh = shape.mesh();
  std::vector<double> h(mesh.element_slots());
  for (double& t : h) t = random.uniform(0, 0.2);
  const ShellThickener thickener(mesh);
  std::vector<Vec3> serial, parallel;
  const Index without = thickener.positions(shape.positions, h, serial);
  const auto threads = make_thread_executor(3);
  ShellThickener::Scratch scratch;
  EXPECT_EQ(thickener.positions(shape.positions, h, parallel, scratch, *threads), without);
  EXPECT_EQ(serial, parallel);
}

TEST(Shells, KeepNoMemoryButTheCallers) {
  const Shape shape = block(ElementType::quad, 6, 5, 0);
  const Mesh mesh = shape.mesh();
  const std::vector<double> h(mesh.element_slots(), 0.1);
  const ShellThickener thickener(mesh);
  SerialExecutor serial;
  const std::size_t before = test::live_allocations();
  {
    ShellThickener::Scratch scratch;
    std::vector<Vec3> x;
    thickener.positions(shape.positions, h, x, scratch, serial);
    const std::size_t grown = test::allocation_count();
    thickener.positions(shape.positions, h, x, scratch, serial);
    EXPECT_EQ(test::allocation_count(), grown);
    thickener.positions(shape.positions, h, x);
  }
  EXPECT_EQ(test::live_allocations(), before);
}

TEST(Shells, AFlatSheetBecomesASlabHoweverItsElementsAreTurned) {
  for (ElementType type : {ElementType::triangle, ElementType::quad})
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      Shape shape = permuted(block(type, 4, 3, 0), seed);
      if (seed % 2 == 1) shape = turned(shape);
      const Mesh mesh = shape.mesh();
      const ShellThickener thickener(mesh);
      const Mesh solid = thickener.solid_mesh(mesh);
      std::vector<Vec3> x;
      const std::vector<double> h(mesh.element_slots(), 0.5);
      EXPECT_EQ(thickener.positions(shape.positions, h, x), 0u);
      ASSERT_EQ(x.size(), solid.vertex_count());
      double total = 0;
      for (Index o = 0; o < solid.element_slots(); ++o) {
        EXPECT_EQ(solid.type(o), type == ElementType::quad ? ElementType::hexahedron : ElementType::wedge);
        EXPECT_EQ(solid.element_id(o), mesh.element_id(o));
        EXPECT_NEAR(volume(solid, o, x), type == ElementType::quad ? 0.5 : 0.25, 1e-12);
        total += volume(solid, o, x);
      }
      EXPECT_NEAR(total, 12 * 0.5, 1e-12);
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        EXPECT_EQ(x[solid_middle(v)], shape.positions[v]);
        EXPECT_NEAR(std::abs(x[solid_above(v)].z()), 0.25, 1e-15);
        EXPECT_NEAR((x[solid_above(v)] + x[solid_below(v)] - 2 * shape.positions[v]).norm(), 0, 1e-15);
        EXPECT_EQ(x[solid_above(v)].z() > 0, x[solid_above(0)].z() > 0);
      }
    }
}

TEST(Shells, AClosedSphereIsOffsetInwardAndOutward) {
  // The boundary of a block of cells, projected onto a sphere. Every solid must have a volume of about area times
  // thickness.
  constexpr int n = 6;
  Shape shape;
  shape.positions = block(ElementType::hexahedron, n, n, n).positions;
  for (Vec3& p : shape.positions) p -= Vec3::Constant(n / 2.0);
  const auto at = [](int x, int y, int z) { return static_cast<Index>((z * (n + 1) + y) * (n + 1) + x); };
  for (int side = 0; side <= n; side += n)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int axis = 0; axis < 3; ++axis) {
          const auto corner = [&](int a, int b) {
            return axis == 0 ? at(side, a, b) : axis == 1 ? at(a, side, b) : at(a, b, side);
          };
          ElementSpec quad;
          quad.type = ElementType::quad;
          quad.vertices = {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)};
          quad.id = static_cast<std::int64_t>(shape.elements.size());
          shape.elements.push_back(quad);
        }
  for (Vec3& p : shape.positions)
    if (p.norm() > 0) p.normalize();
  const Mesh mesh = permuted(shape, 0).mesh();
  const auto positions = permuted(shape, 0).positions;
  const ShellThickener thickener(mesh);
  std::vector<Vec3> x;
  EXPECT_EQ(thickener.positions(positions, std::vector<double>(mesh.element_slots(), 0.1), x), 0u);
  const Mesh solid = thickener.solid_mesh(mesh);
  double total = 0;
  for (Index o = 0; o < solid.element_slots(); ++o) {
    EXPECT_GT(volume(solid, o, x), 0);
    total += volume(solid, o, x);
  }
  EXPECT_NEAR(total, 4 * M_PI * 0.1, 0.06);
}

TEST(Shells, VolumesPassUnchanged) {
  const Shape shape = permuted(mixed_block(2, 1), 3);
  const Mesh mesh = shape.mesh();
  const ShellThickener thickener(mesh);
  const Mesh solid = thickener.solid_mesh(mesh);
  ASSERT_EQ(solid.element_count(), mesh.element_count());
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    EXPECT_FALSE(is_shell(solid.type(o)));
    EXPECT_EQ(solid.object(o), mesh.object(o));
    if (is_shell(mesh.type(o))) continue;
    EXPECT_EQ(solid.type(o), mesh.type(o));
    for (std::size_t i = 0; i < mesh.vertices(o).size(); ++i) {
      EXPECT_EQ(solid.vertices(o)[i], solid_middle(mesh.vertices(o)[i]));
      EXPECT_EQ(solid.vertex_id(solid.vertices(o)[i]), 3 * mesh.vertex_id(mesh.vertices(o)[i]));
    }
    EXPECT_EQ(solid.polytope_faces(o).size(), mesh.polytope_faces(o).size());
  }
}

TEST(Shells, SharedVerticesStayShared) {
  Shape shape = block(ElementType::quad, 2, 1, 0);
  shape.elements[1].object = 1;
  const Mesh mesh = shape.mesh();
  const Mesh solid = ShellThickener(mesh).solid_mesh(mesh);
  std::size_t common = 0;
  for (Index v : solid.vertices(0)) common += std::ranges::count(solid.vertices(1), v) != 0;
  EXPECT_EQ(common, 4u);
}

TEST(Shells, ThicknessIsWeightedByArea) {
  Shape shape = block(ElementType::quad, 2, 1, 0);
  for (Vec3& p : shape.positions)
    if (p.x() == 2) p.x() = 4;  // areas 1 and 3
  const Mesh mesh = shape.mesh();
  std::vector<Vec3> x;
  EXPECT_EQ(ShellThickener(mesh).positions(shape.positions, std::vector<double>{1.0, 2.0}, x), 0u);
  for (Index v = 0; v < 6; ++v) {
    const double expected = shape.positions[v].x() == 0 ? 1 : shape.positions[v].x() == 1 ? 1.75 : 2;
    EXPECT_NEAR((x[solid_above(v)] - x[solid_below(v)]).norm(), expected, 1e-14);
  }
}

TEST(Shells, FoldsAndJunctionsGetAFiniteNormal) {
  // A sheet that is folded back onto itself has no normal along the crease, which is counted. With a third sheet at the
  // crease there is a normal again.
  Shape shape;
  shape.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 1}, {0, 1, 1}};
  const auto quad = [&](std::vector<Index> v) {
    ElementSpec element;
    element.type = ElementType::quad;
    element.vertices = std::move(v);
    element.id = static_cast<std::int64_t>(shape.elements.size());
    shape.elements.push_back(element);
  };
  quad({0, 2, 3, 1});
  quad({0, 1, 5, 4});
  std::vector<Vec3> x;
  Mesh mesh = shape.mesh();
  EXPECT_EQ(ShellThickener(mesh).positions(shape.positions, std::vector<double>(2, 0.2), x), 2u);
  EXPECT_NEAR((x[solid_above(0)] - Vec3(0, 0, 0.1)).norm(), 0, 1e-15) << "the first shell's own normal";
  quad({0, 1, 7, 6});
  mesh = shape.mesh();
  EXPECT_EQ(ShellThickener(mesh).positions(shape.positions, std::vector<double>(3, 0.2), x), 0u);
  for (const Vec3& p : x) EXPECT_TRUE(p.allFinite());
  for (Index v : {0u, 1u}) EXPECT_NEAR((x[solid_above(v)] - x[solid_below(v)]).norm(), 0.2, 1e-12);
  // All vertices have the same position.
  const std::vector<Vec3> point(8, Vec3(3, 4, 5));
  EXPECT_EQ(ShellThickener(mesh).positions(point, std::vector<double>(3, 0.2), x), 8u);
  EXPECT_NEAR((x[solid_above(7)] - Vec3(3, 4, 5.1)).norm(), 0, 1e-15);
  // Areas are beyond the range of doubles.
  std::vector<Vec3> huge = shape.positions;
  for (Vec3& p : huge) p *= 1e200;
  ShellThickener(mesh).positions(huge, std::vector<double>(3, 0.2), x);
  for (const Vec3& p : x) EXPECT_TRUE(p.allFinite());
}

TEST(Shells, AMoebiusStripIsLegal) {
  Shape shape;
  for (int i = 0; i < 7; ++i)
    for (double side : {-0.3, 0.3}) {
      const double a = 2 * M_PI * i / 7;
      const double r = 1 + side * std::cos(a / 2);
      shape.positions.emplace_back(r * std::cos(a), r * std::sin(a), side * std::sin(a / 2));
    }
  for (Index i = 0; i < 7; ++i) {
    const Index j = (i + 1) % 7, twist = i == 6 ? 1 : 0;
    ElementSpec element;
    element.type = ElementType::quad;
    element.vertices = {2 * i, 2 * i + 1, 2 * j + (1 - twist), 2 * j + twist};
    element.id = i;
    shape.elements.push_back(element);
  }
  const Mesh mesh = shape.mesh();
  std::vector<Vec3> x;
  const ShellThickener thickener(mesh);
  thickener.positions(shape.positions, std::vector<double>(7, 0.05), x);
  for (const Vec3& p : x) EXPECT_TRUE(p.allFinite());
  EXPECT_EQ(thickener.solid_mesh(mesh).element_count(), 7u);
}

TEST(Shells, RefusesBadInput) {
  const Shape shape = block(ElementType::quad, 2, 1, 0);
  const ShellThickener thickener(shape.mesh());
  std::vector<Vec3> out;
  const std::vector<double> good(2, 0.1);
  EXPECT_THROW(thickener.positions(std::vector<Vec3>(5, Vec3::Zero()), good, out), InputError);
  EXPECT_THROW(thickener.positions(shape.positions, std::vector<double>(3, 0.1), out), InputError);
  for (double bad : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) try {
      thickener.positions(shape.positions, std::vector<double>{0.1, bad}, out);
      FAIL() << bad;
    } catch (const InputError& error) {
      EXPECT_EQ(error.dataset(), "thickness");
      EXPECT_EQ(error.index(), 1);
    }
  EXPECT_EQ(thickener.positions(shape.positions, std::vector<double>(2, 0.0), out), 0u);
  const std::vector<std::int64_t> ids = {-4, 0, 7};
  EXPECT_EQ(solid_vertex_ids(ids), (std::vector<std::int64_t>{-12, -11, -10, 0, 1, 2, 21, 22, 23}));
  const std::vector<std::int64_t> large = {0, std::numeric_limits<std::int64_t>::max() / 2};
  EXPECT_THROW(solid_vertex_ids(large), InputError);
}

}  // namespace
}  // namespace volccd
