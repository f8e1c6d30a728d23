// The surface that is drawn: boundary, sections, normals, and the bodies that decide what a picture shows.
#include <volccd/pictures/surface.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "pictures/picture_shapes.hpp"

namespace volccd {
namespace {

using namespace test;

double area(const Surface& surface, bool sections) {
  double sum = 0;
  for (const SurfaceTriangle& t : surface.triangles) {
    const Vec3 &a = surface.points[t.corners[0]], &b = surface.points[t.corners[1]], &c = surface.points[t.corners[2]];
    if (!sections || t.section) sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

TEST(PictureSurface, IsTheBoundaryOfVolumes) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                                 ElementType::hexahedron, ElementType::polytope}) {
    const Surface surface = surface_of_shape(permuted(block(type, 3, 2, 4), 5));
    EXPECT_NEAR(area(surface, false), 2 * (6 + 8 + 12), 1e-9) << to_string(type);
  }
  EXPECT_NEAR(area(surface_of_shape(block(ElementType::quad, 5, 3, 1)), false), 15, 1e-9);
}

TEST(PictureSurface, CutsCloseWithTheSectionOfTheBody) {
  const Shape whole = [] {
    Shape shape = block(ElementType::hexahedron, 1, 1, 1);
    for (Vec3& p : shape.positions) p = p.cwiseProduct(Vec3(3, 2, 4));
    return shape;
  }();
  const std::vector<CuttingPlane> planes{{Vec3(1, 2, 0.7).normalized(), 1.9}, {Vec3(-1, 0.3, 0.2).normalized(), -0.4}};
  const auto cut_of = [&](const Shape& shape, std::size_t count) {
    Surface surface = surface_of_shape(shape);
    const std::vector<std::uint16_t> colours(shape.elements.size(), 0);
    cut(surface, cells_of_shape(shape), shape.positions, colours, std::span(planes).first(count));
    for (const SurfaceTriangle& t : surface.triangles)
      for (const Index corner : t.corners)
        for (std::size_t i = 0; i < count; ++i)
          EXPECT_LT(planes[i].normal.dot(surface.points[corner]) - planes[i].offset, 1e-9);
    EXPECT_EQ(surface.normals.size(), surface.triangles.size());
    return surface;
  };
  for (std::size_t count : {1, 2}) {
    const Surface expected = cut_of(whole, count);
    EXPECT_GT(area(expected, true), 1);
    for (const ElementType type : {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                                   ElementType::hexahedron, ElementType::polytope}) {
      const Surface surface = cut_of(block(type, 3, 2, 4), count);
      EXPECT_NEAR(area(surface, true), area(expected, true), 1e-9) << to_string(type) << ' ' << count;
      EXPECT_NEAR(area(surface, false), area(expected, false), 1e-9) << to_string(type) << ' ' << count;
    }
  }
}

TEST(PictureSurface, CutAlongFacesOfElementsIsClosedToo) {
  const Shape shape = block(ElementType::hexahedron, 2, 2, 2);
  Surface surface = surface_of_shape(shape);
  const std::vector<std::uint16_t> colours(shape.elements.size(), 0);
  const std::vector<CuttingPlane> planes{{Vec3::UnitX(), 1}};
  cut(surface, cells_of_shape(shape), shape.positions, colours, planes);
  EXPECT_NEAR(area(surface, true), 4, 1e-12);
  EXPECT_NEAR(area(surface, false), 16, 1e-12);
}

TEST(PictureSurface, NormalsAreSharedAcrossFlatEdgesAndNotAcrossCreases) {
  const Surface cube = surface_of_shape(block(ElementType::tetrahedron, 2, 2, 2));
  for (std::size_t i = 0; i < cube.triangles.size(); ++i)
    for (const Eigen::Vector3f& n : cube.normals[i]) EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1, 1e-6);
  Shape roof = block(ElementType::quad, 2, 1, 1);  // bent by 2 * 10 degrees
  for (Vec3& p : roof.positions) p.z() = -std::abs(p.x() - 1) * std::tan(std::numbers::pi / 18);
  std::swap(roof.elements[1].vertices[1], roof.elements[1].vertices[3]);  // numbered the other way round
  const Surface bent = surface_of_shape(roof);
  int ridge = 0;
  for (std::size_t i = 0; i < bent.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (bent.points[bent.triangles[i].corners[k]].x() == 1) {
        ++ridge;
        EXPECT_LT(std::abs(bent.normals[i][k].x()), 0.1);
      }
  EXPECT_EQ(ridge, 6);
}

TEST(PictureSurface, FragmentsAreNoBodies) {
  Shape shape;
  shape.append(block(ElementType::hexahedron, 4, 4, 4), 1);
  shape.append(block(ElementType::hexahedron, 1, 1, 1).translate({500, 0, 0}), 1);  // a fragment
  shape.append(block(ElementType::quad, 1, 1, 1).translate({-30, 0, 0}), 2);        // small, but the whole of part 2
  const SequenceCells cells = cells_of_shape(shape);
  double low = 0, high = 0;
  for (const Index v : vertices_of_bodies(cells, shape.positions.size())) {
    low = std::min(low, shape.positions[v].x());
    high = std::max(high, shape.positions[v].x());
  }
  EXPECT_EQ(low, -30);
  EXPECT_EQ(high, 4);
  EXPECT_EQ(vertices_of_bodies(cells, shape.positions.size(), 0).size(), shape.positions.size());
}

}  // namespace
}  // namespace volccd
