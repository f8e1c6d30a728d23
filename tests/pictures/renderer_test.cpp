// What a picture shows: coverage, hidden surfaces, cameras and views.
#include <volccd/pictures/renderer.hpp>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/pictures/palette.hpp>

#include "pictures/picture_shapes.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

using namespace test;

TEST(Pictures, CubeCoversItsSquareAndNothingElse) {
  const Surface surface = surface_of_shape(block(ElementType::hexahedron, 1, 1, 1));
  const std::vector<Colour> colours{object_colour(0)};
  const Camera camera = Camera::fit(surface.points, front(), 120, 100, 0.1);
  const Image image = render(surface, colours, {}, camera, 120, 100, plain());
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 120; ++x)
      ASSERT_EQ(image.at(x, y) != kWhite, x >= 20 && x < 100 && y >= 10 && y < 90) << x << ' ' << y;
}

/// The first element that a ray through the middle of the pixel hits, by Cramer's rule on all triangles; -1: nothing;
/// -2: undecided because of rounding.
int first_hit(const Surface& surface, const Camera& camera, double x, double y) {
  const bool flat = camera.orthographic();
  const Vec3 p = camera.from_picture(x, y, flat ? -1 : 1), q = camera.from_picture(x, y, flat ? -2 : 0.5);
  double nearest = 1e300;
  int hit = -1;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& corners = surface.triangles[i].corners;
    const Vec3 a = camera.to_view(surface.points[corners[0]]);
    Eigen::Matrix3d m;
    m << camera.to_view(surface.points[corners[1]]) - a, camera.to_view(surface.points[corners[2]]) - a, p - q;
    const Vec3 s = m.inverse() * (p - a);  // weights, and the depth beyond p
    const double inside = std::min({s[0], s[1], 1 - s[0] - s[1]});
    if (std::abs(inside) < 1e-6 || (inside > 0 && std::abs(s[2] - nearest) < 1e-5)) return -2;
    if (inside < 0 || s[2] > nearest) continue;
    nearest = s[2];
    hit = surface.triangles[i].colour;
  }
  return hit;
}

TEST(Pictures, NearerHidesFartherAsRaysSay) {
  const std::vector<Colour> colours{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {255, 0, 255}, {0, 255, 255}};
  std::size_t compared = 0;
  const auto seeds = static_cast<std::size_t>(test::trials(8));
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    Shape shape;
    shape.positions = jittered(std::vector<Vec3>(36, Vec3::Zero()), 1, seed);
    for (Index i = 0; i < 12; ++i)
      shape.elements.push_back({.type = ElementType::triangle, .vertices = {3 * i, 3 * i + 1, 3 * i + 2}, .id = i});
    const SequenceCells cells = cells_of_shape(shape);
    std::vector<std::uint16_t> colour_of(12);
    for (std::size_t i = 0; i < 12; ++i) colour_of[i] = static_cast<std::uint16_t>(i % 6);
    const Surface surface = surface_of(cells, shape.positions, colour_of);
    View view;
    view.azimuth = 40.0 * static_cast<double>(seed);
    view.orthographic = seed % 2 == 0;
    const Camera camera = Camera::fit(shape.positions, view, 90, 70);
    const Image image = render(surface, colours, {}, camera, 90, 70, plain());
    for (int y = 0; y < 70; ++y)
      for (int x = 0; x < 90; ++x) {
        const int hit = first_hit(surface, camera, x + 0.5, y + 0.5);
        if (hit == -2) continue;
        ++compared;
        const Colour seen = image.at(x, y);
        if (hit == -1) {
          ASSERT_EQ(seen, kWhite);
          continue;
        }
        const Colour own = colours[static_cast<std::size_t>(hit)];
        const int high = std::max({seen.r, seen.g, seen.b});
        ASSERT_TRUE((seen.r > high / 2) == (own.r > 0) && (seen.g > high / 2) == (own.g > 0) &&
                    (seen.b > high / 2) == (own.b > 0))
            << "seed " << seed << ", pixel " << x << ' ' << y;
      }
  }
  EXPECT_GT(compared, 5600u * seeds);
}

TEST(Pictures, CameraSeesAllItsPoints) {
  const std::vector<Vec3> points = jittered(std::vector<Vec3>(200, Vec3(50, -3, 7)), 4, 1);
  for (const char* name : {"front", "back", "left", "right", "side", "top", "bottom", "iso", "12.5,-33"})
    for (const char up : {'x', 'y', 'z'})
      for (const bool flat : {false, true}) {
        View view;
        parse_view(name, view);
        view.up = up;
        view.orthographic = flat;
        const Camera camera = Camera::fit(points, view, 300, 200, 0.05);
        double nearest_border = 1e9;
        for (const Vec3& point : points) {
          const Camera::Projected p = camera.project(point);
          nearest_border = std::min({nearest_border, p.x, p.y, 300 - p.x, 200 - p.y});
          EXPECT_LT((camera.from_picture(p.x, p.y, p.nearness) - camera.to_view(point)).norm(), 1e-9);
        }
        EXPECT_NEAR(nearest_border, 10, 1) << name << ' ' << up << ' ' << flat;
      }
}

TEST(Pictures, ViewsLookWhereTheySay) {
  const auto pixel_of = [](const char* name, char up, const Vec3& point) {
    View view;
    parse_view(name, view);
    view.up = up;
    const Camera::Projected p =
        Camera::fit(box_corners(Vec3::Constant(-1), Vec3::Constant(1)), view, 100, 100).project(point);
    return Eigen::Vector2d(p.x - 50, 50 - p.y);
  };
  EXPECT_GT(pixel_of("front", 'z', {1, 0, 0}).x(), 10);  // x to the right
  EXPECT_GT(pixel_of("front", 'z', {0, 0, 1}).y(), 10);  // z upwards
  EXPECT_LT(pixel_of("back", 'z', {1, 0, 0}).x(), -10);
  EXPECT_GT(pixel_of("side", 'z', {0, 1, 0}).x(), 10);
  EXPECT_GT(pixel_of("top", 'z', {0, 1, 0}).y(), 10);
  EXPECT_GT(pixel_of("top", 'z', {1, 0, 0}).x(), 10);
  EXPECT_GT(pixel_of("front", 'y', {0, 1, 0}).y(), 10);
  EXPECT_GT(pixel_of("front", 'y', {1, 0, 0}).x(), 10);
  EXPECT_GT(pixel_of("front", 'x', {1, 0, 0}).y(), 10);
  View view;
  for (const char* bad : {"", "above", "1", "1,", "1,2,3", "0,91", "nan,0"})
    EXPECT_THROW(parse_view(bad, view), ConfigError);
}

}  // namespace
}  // namespace volccd
