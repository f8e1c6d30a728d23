#include <volccd/experiments/scenes/deform.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/stacking.hpp>
#include <volccd/io/sequence/reader.hpp>

#include "support/test_data.hpp"

namespace volccd {
namespace {

/// 6 x 4 x 2 cells of tetrahedra: long axis x, short axis z, centre (3, 2, 1).
Shape slab() { return block(ElementType::tetrahedron, 6, 4, 2); }

std::vector<Vec3> frame(const Scene& scene, int k) {
  std::vector<Vec3> x;
  scene.positions(k, x);
  return x;
}

std::vector<Vec3> last_frame(const Shape& mesh, DeformMotion motion) {
  return frame(*make_deform(mesh, {.motions = {motion}}), 1);
}

double largest_move(const Scene& scene, int k) {
  const std::vector<Vec3> x0 = frame(scene, k), x1 = frame(scene, k + 1);
  double max = 0;
  for (std::size_t v = 0; v < x0.size(); ++v) max = std::max(max, (x1[v] - x0[v]).norm());
  return max;
}

TEST(Deform, FirstFrameIsTheMeshItself) {
  for (const char* motions : {"twist", "bend", "squeeze", "jitter", "twist,bend,squeeze,jitter"}) {
    const Shape mesh = mixed_block(2, 2);
    const auto scene = make_deform(mesh, {.motions = parse_deform_motions(motions)});
    ASSERT_EQ(scene->vertex_count(), mesh.positions.size());
    const std::vector<Vec3> x = frame(*scene, 0);
    for (std::size_t v = 0; v < x.size(); ++v) EXPECT_LT((x[v] - mesh.positions[v]).norm(), 1e-14) << motions;
  }
}

TEST(Deform, TwistTurnsTheEndsAgainstEachOther) {
  const Shape mesh = slab();
  const std::vector<Vec3> x = last_frame(mesh, {DeformKind::twist, 90});
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 d0 = mesh.positions[v] - Vec3(3, 2, 1), d1 = x[v] - Vec3(3, 2, 1);
    EXPECT_EQ(x[v].x(), mesh.positions[v].x());
    EXPECT_NEAR(std::hypot(d1.y(), d1.z()), std::hypot(d0.y(), d0.z()), 1e-12);
    const double angle = 90 * d0.x() / 6 * M_PI / 180;
    EXPECT_NEAR(d1.y() * d0.z() - d1.z() * d0.y(), -std::sin(angle) * (d0.y() * d0.y() + d0.z() * d0.z()), 1e-12);
  }
}

TEST(Deform, BendKeepsTheLengthOfTheMiddle) {
  const std::vector<Vec3> line = [] {
    std::vector<Vec3> x;
    for (int i = 0; i <= 6; ++i) x.emplace_back(i, 2, 1);
    return x;
  }();
  const Shape mesh = slab();
  const std::vector<Vec3> x = last_frame(mesh, {DeformKind::bend, 90});
  double length = 0;
  Vec3 first, last;
  std::vector<Vec3> moved;
  for (const Vec3& p : line)
    for (std::size_t v = 0; v < x.size(); ++v)
      if (mesh.positions[v] == p) moved.push_back(x[v]);
  ASSERT_EQ(moved.size(), 7u);
  for (std::size_t i = 0; i + 1 < moved.size(); ++i) length += (moved[i + 1] - moved[i]).norm();
  EXPECT_NEAR(length, 6, 0.1);  // chords of the arc
  first = moved[1] - moved[0];
  last = moved[6] - moved[5];
  // The directions of the first and last chord differ by 5/6 of the angle between the tangents at the ends.
  EXPECT_NEAR(std::acos(first.normalized().dot(last.normalized())) * 180 / M_PI, 75, 1e-9);
  EXPECT_EQ(moved[3], Vec3(3, 2, 1));
}

TEST(Deform, SqueezeKeepsVolumes) {
  const Shape mesh = slab();
  const std::vector<Vec3> x = last_frame(mesh, {DeformKind::squeeze, 0.36});
  EXPECT_NEAR(x[6].x() - x[0].x(), 0.64 * 6, 1e-12);
  for (std::size_t v = 0; v < x.size(); ++v) EXPECT_NEAR(x[v].z() - 1, (mesh.positions[v].z() - 1) / 0.8, 1e-12);
}

TEST(Deform, JitterStaysWithinItsAmountAndDependsOnTheSeed) {
  const Shape mesh = slab();
  const double reach = 0.25 * mean_edge_length(mesh);
  const auto one = make_deform(mesh, {.motions = {{DeformKind::jitter, 0.25}}, .frames = 4});
  const auto other = make_deform(mesh, {.motions = {{DeformKind::jitter, 0.25}}, .frames = 4, .seed = 2});
  for (int k = 1; k < 4; ++k) {
    const std::vector<Vec3> x = frame(*one, k);
    double max = 0;
    for (std::size_t v = 0; v < x.size(); ++v) max = std::max(max, (x[v] - mesh.positions[v]).cwiseAbs().maxCoeff());
    EXPECT_LE(max, reach);
    EXPECT_GT(max, 0.9 * reach);
    EXPECT_NE(x, frame(*other, k));
    EXPECT_NE(x, frame(*one, k - 1));
  }
}

TEST(Deform, DefaultsMoveTheFastestVertexAboutAnEdgeAStep) {
  const Shape mesh = block(ElementType::tetrahedron, 12, 6, 5);
  const double edge = mean_edge_length(mesh);
  for (const char* kind : {"twist", "bend", "squeeze", "jitter"})
    for (const int steps : {2, 4}) {
      const auto scene = make_deform(mesh, {.motions = parse_deform_motions(kind), .frames = steps});
      for (int k = 0; k + 1 < steps; ++k) {
        EXPECT_GT(largest_move(*scene, k), 0.2 * edge) << kind;
        EXPECT_LT(largest_move(*scene, k), 2 * edge) << kind;
      }
    }
}

TEST(Deform, SameFramesAgainInAnyOrder) {
  const DeformConfig config{
      .motions = parse_deform_motions("twist,jitter,collide"), .copies = 3, .frames = 4, .seed = 9};
  const auto one = make_deform(slab(), config), two = make_deform(slab(), config);
  const std::vector<Vec3> last = frame(*two, 3);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(frame(*one, k), frame(*two, k));
  EXPECT_EQ(frame(*one, 3), last);
}

TEST(Deform, CopiesAreSeparateObjects) {
  Shape parts = block(ElementType::hexahedron, 3, 2, 1);
  Shape second = block(ElementType::tetrahedron, 1, 1, 1);
  const Shape mesh = Shape().append(parts, 7).append(second.translate(Vec3(5, 0, 0)), 3);
  const auto scene = make_deform(mesh, {.copies = 3});
  const Mesh made = scene_mesh(*scene, 0);
  EXPECT_EQ(made.vertex_count(), 3 * mesh.positions.size());
  EXPECT_EQ(made.element_count(), 3 * mesh.elements.size());
  std::set<std::int64_t> ids;
  for (Index o = 0; o < made.element_slots(); ++o) {
    const std::size_t copy = o / mesh.elements.size(), e = o % mesh.elements.size();
    EXPECT_EQ(made.object(o), static_cast<int>(2 * copy) + (mesh.elements[e].object == 7 ? 1 : 0));
    EXPECT_EQ(made.type(o), mesh.elements[e].type);
    if (copy == 0) {
      EXPECT_EQ(made.element_id(o), mesh.elements[e].id);
    }
    ids.insert(made.element_id(o));
    for (const Index v : made.vertices(o)) EXPECT_EQ(v / mesh.positions.size(), copy);
  }
  EXPECT_EQ(ids.size(), made.element_count());
}

/// Depth along z to which neighbouring copies, as boxes, are inside each other.
double box_overlap(const std::vector<Vec3>& x, std::size_t n, std::size_t copy) {
  double top = -INFINITY, bottom = INFINITY;
  for (std::size_t v = 0; v < n; ++v) {
    top = std::max(top, x[copy * n + v].z());
    bottom = std::min(bottom, x[(copy + 1) * n + v].z());
  }
  return top - bottom;
}

TEST(Deform, CollidingBlocksEndAsDeepInsideEachOtherAsAsked) {
  const Shape mesh = slab();
  const double edge = mean_edge_length(mesh);
  const auto scene = make_deform(mesh, {.motions = {{DeformKind::collide, 1.5}}, .copies = 3, .frames = 3});
  for (const std::size_t copy : {0u, 1u}) {
    EXPECT_NEAR(box_overlap(frame(*scene, 0), mesh.positions.size(), copy), -0.5 * edge, 1e-12);
    EXPECT_NEAR(box_overlap(frame(*scene, 2), mesh.positions.size(), copy), 1.5 * edge, 1e-12);
  }
  // Copies are translated only, and are not exactly in the pose of their neighbour.
  const std::vector<Vec3> x = frame(*scene, 2);
  const std::size_t n = mesh.positions.size();
  EXPECT_NEAR((x[1] - x[0] - (mesh.positions[1] - mesh.positions[0])).norm(), 0, 1e-12);
  EXPECT_GT(std::abs((x[n] - x[0]).x()), 1e-3);
}

TEST(Deform, TwistedCopiesCollideToo) {
  const Shape mesh = slab();
  const auto scene =
      make_deform(mesh, {.motions = parse_deform_motions("twist:40,collide:1"), .copies = 3, .frames = 2});
  std::vector<Vec3> x = frame(*scene, 1);
  const auto triangles = face_triangles(mesh);
  const double edge = mean_edge_length(mesh);
  const std::size_t n = mesh.positions.size();
  for (const std::size_t copy : {0u, 1u})
    EXPECT_NEAR(
        touching_shift(std::span(x).subspan(copy * n, n), std::span(x).subspan((copy + 1) * n, n), triangles, 2, edge),
        edge, 1e-12);
}

TEST(Deform, MotionLists) {
  const auto motions = parse_deform_motions("twist:-60.5,collide");
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_EQ(motions[0].kind, DeformKind::twist);
  EXPECT_EQ(motions[0].amount, -60.5);
  EXPECT_FALSE(motions[1].amount);
  EXPECT_EQ(parse_deform_motions("bend", 3.0)[0].amount, 3.0);
  for (const char* bad :
       {"", "spin", "twist,", ",twist", "twist:", "twist:x", "twist:nan", "twist:1e9", "twist:1:2", " twist"})
    EXPECT_THROW(parse_deform_motions(bad), ConfigError) << bad;
  EXPECT_THROW(parse_deform_motions("twist,collide", 3.0), ConfigError);
  EXPECT_THROW(parse_deform_motions("twist:1", 3.0), ConfigError);
}

TEST(Deform, RefusesBadConfigurations) {
  const Shape mesh = slab();
  const std::vector<DeformConfig> bad = {
      {.motions = {}},
      {.motions = {{DeformKind::twist}, {DeformKind::twist}}},
      {.motions = {{DeformKind::collide}}},
      {.motions = {{DeformKind::squeeze, 1.0}}},
      {.motions = {{DeformKind::jitter, -1.0}}},
      {.motions = {{DeformKind::twist, NAN}}},
      {.motions = {{DeformKind::collide, INFINITY}}, .copies = 2},
      {.copies = 0},
      {.copies = 10'001},
      {.frames = 1},
      {.frames = 100'001},
  };
  for (std::size_t i = 0; i < bad.size(); ++i) EXPECT_THROW(make_deform(mesh, bad[i]), ConfigError) << i;
}

TEST(Deform, RefusesBadMeshes) {
  EXPECT_THROW(make_deform(Shape()), InputError);
  Shape mesh = slab();
  mesh.positions[3].y() = NAN;
  EXPECT_THROW(make_deform(mesh), InputError);
  Shape point = slab();
  for (Vec3& p : point.positions) p.setZero();
  EXPECT_THROW(make_deform(point), InputError);
}

TEST(Deform, FlatAndThinMeshesAreFine) {
  for (const char* motions : {"twist", "bend", "squeeze", "jitter", "twist,bend,squeeze,jitter,collide"}) {
    const auto scene = make_deform(block(ElementType::quad, 5, 1, 1),
                                   {.motions = parse_deform_motions(motions), .copies = 2, .frames = 3});
    for (int k = 0; k < 3; ++k)
      for (const Vec3& p : frame(*scene, k)) EXPECT_TRUE(p.allFinite());
  }
}

TEST(TouchingShift, OfTwoPyramidsPointToFace) {
  // The apex of the lower tetrahedron is below the middle of the base of the upper one.
  const Shape pyramid{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0), Vec3(0.5, 0.5, 1)},
                      {{.type = ElementType::pyramid, .vertices = {0, 1, 2, 3, 4}}}};
  std::vector<Vec3> upper = pyramid.positions;
  const auto triangles = face_triangles(pyramid);
  EXPECT_EQ(triangles.size(), 6u);
  EXPECT_NEAR(touching_shift(pyramid.positions, upper, triangles, 2, 0.3), 1, 1e-12);
  for (Vec3& p : upper) p += Vec3(0.75, 0, 0);  // a corner of the base is now above a slope
  EXPECT_NEAR(touching_shift(pyramid.positions, upper, triangles, 2, 0.3), 0.5, 1e-12);
  for (Vec3& p : upper) p += Vec3(10, 0, 7);  // the projections do not overlap, so that boxes count
  EXPECT_NEAR(touching_shift(pyramid.positions, upper, triangles, 2, 0.3), -6, 1e-12);
}

TEST(MeanEdgeLength, CountsEachEdgeOnce) {
  EXPECT_NEAR(mean_edge_length(block(ElementType::hexahedron, 3, 2, 2)), 1, 1e-15);
  // Kuhn's split of one cube: 12 edges, 6 face diagonals, 1 space diagonal.
  EXPECT_NEAR(mean_edge_length(block(ElementType::tetrahedron, 1, 1, 1)),
              (12 + 6 * std::sqrt(2.0) + std::sqrt(3.0)) / 19, 1e-14);
}

TEST(DeformOnSharedData, ThreeTwistedOctopiCollide) {
  VOLCCD_NEEDS_DATA(path, "octopus-4k.vtkhdf");
  const Shape mesh = shape_from_file(path);
  ASSERT_EQ(mesh.elements.size(), 4069u);
  ASSERT_EQ(mesh.positions.size(), 1184u);
  const double edge = mean_edge_length(mesh);
  EXPECT_NEAR(edge, 0.0327, 0.0001);
  const auto scene = make_deform(mesh, {.motions = parse_deform_motions("twist,collide"), .copies = 3});
  EXPECT_GT(largest_move(*scene, 0), 0.5 * edge);
  EXPECT_LT(largest_move(*scene, 0), 4 * edge);
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  int up = 0;
  (high - low).minCoeff(&up);
  const auto triangles = face_triangles(mesh);
  for (int k : {0, 1})
    for (const std::size_t copy : {0u, 1u}) {
      const std::vector<Vec3> x = frame(*scene, k);
      const std::span<const Vec3> lower = std::span(x).subspan(copy * 1184, 1184),
                                  upper = std::span(x).subspan((copy + 1) * 1184, 1184);
      EXPECT_NEAR(touching_shift(lower, upper, triangles, up, edge), k == 0 ? -0.5 * edge : edge, 1e-9);
    }
}

}  // namespace
}  // namespace volccd
